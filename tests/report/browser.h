// A page in a headless browser: screenshot, log, final document.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace palpa {

/// Of a screenshot, rows from top to bottom.
struct Screen {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> rgb;
  const std::uint8_t* at(int x_px, int y_px) const { return &rgb[3 * (static_cast<std::size_t>(y_px) * width_px + x_px)]; }
};

struct Shown {
  Screen screen;
  std::string document;              ///< the page in its final state
  std::vector<std::string> console;  ///< its log, with errors
};

bool has_browser();

/// Opens `page` in Chromium, with `options` beside those for machines without screen and graphics card, runs it for some
/// seconds of virtual time, and captures it; its files go to `folder`.
Shown open_page(const std::filesystem::path& page, const std::filesystem::path& folder,
                const std::vector<std::string>& options = {});

/// The page with another script, permitted in its Content-Security-Policy.
std::string with_script(const std::string& html, const std::string& script, const std::filesystem::path& folder);

}  // namespace palpa
