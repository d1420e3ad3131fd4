// A picture in memory, and as a PNG.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace palpa {

/// Rows from top to bottom, three bytes red, green, blue each.
struct Picture {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> rgb;
};

/// The PNG file of a picture, as bytes; the same picture gives the same bytes.
std::string png_of(const Picture& picture);
/// Writes it. Throws LoadError where the file cannot be written.
void save_png(const Picture& picture, const std::filesystem::path& file);

}  // namespace palpa
