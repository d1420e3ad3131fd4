// TIFF and BigTIFF as written by other programs, from their specification.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "files.h"

namespace palpa::test {

struct TiffToWrite {
  std::int64_t columns = 6, rows = 5, images = 4;
  int bits = 16, format = 1;  ///< whole numbers without sign; 2 with sign; 3 floating point
  bool is_bigtiff = false, big_endian = false, deflated = false;
  std::int64_t rows_per_strip = 2;
  std::int64_t tile = 0;  ///< side of a tile, a multiple of 16; 0: strips
  std::string description{};
  double pixels_per_cm = 0.0;
  std::map<int, std::uint64_t> also{};  ///< further tags with one number, or other numbers of these
  std::int64_t first_image = 0;         ///< its k
  std::string unlisted{};               ///< bytes behind the numbers of the first image

  static std::int64_t value(std::int64_t i, std::int64_t j, std::int64_t k) { return i + 10 * j + 50 * k; }

  std::string number(std::uint64_t value, int bytes) const {
    std::string text = bytes_of(value).substr(0, static_cast<std::size_t>(bytes));
    return big_endian ? std::string(text.rbegin(), text.rend()) : text;
  }

  std::string voxel(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const std::int64_t v = i < columns && j < rows ? value(i, j, k) : 0;
    if (format == 3 && bits == 32) return bytes_of(static_cast<float>(v), big_endian);
    if (format == 3) return bytes_of(static_cast<double>(v), big_endian);
    return number(static_cast<std::uint64_t>(v), bits / 8);
  }

  /// Strips or tiles of an image.
  std::vector<std::string> pieces(std::int64_t k) const {
    const std::int64_t high = tile > 0 ? tile : rows_per_strip, wide = tile > 0 ? tile : columns;
    std::vector<std::string> all;
    for (std::int64_t top = 0; top < rows; top += high)
      for (std::int64_t left = 0; left < columns; left += wide) {
        std::string piece;
        for (std::int64_t j = top; j < (tile > 0 ? top + high : std::min(top + high, rows)); ++j)
          for (std::int64_t i = left; i < left + wide; ++i) piece += voxel(i, j, k);
        if (deflated) {
          std::string packed(piece.size() + 100, '\0');
          uLongf size = packed.size();
          ::compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(piece.data()),
                     piece.size());
          piece = packed.substr(0, size);
        }
        all.push_back(piece);
      }
    return all;
  }

  /// The first image is listed; further ones lie behind its numbers, before its list, as ImageJ writes large stacks.
  std::string bytes_of_unlisted(std::int64_t all) const {
    TiffToWrite listed = *this;
    listed.images = 1;
    for (std::int64_t k = 1; k < all; ++k)
      for (const std::string& piece : pieces(k)) listed.unlisted += piece;
    return listed.bytes();
  }

  std::string bytes() const {
    const int offset = is_bigtiff ? 8 : 4;
    std::string file = std::string(big_endian ? "MM" : "II") + number(is_bigtiff ? 43 : 42, 2);
    if (is_bigtiff) file += number(8, 2) + number(0, 2);
    std::size_t link = file.size();
    file += number(0, offset);
    for (std::int64_t n = 0; n < images; ++n) {
      std::string offsets, counts, resolution;
      const std::vector<std::string> parts = pieces(first_image + n);
      for (const std::string& piece : parts) {
        offsets += number(file.size(), offset), counts += number(piece.size(), offset);
        file += piece;
      }
      if (n == 0) file += unlisted;
      const std::uint64_t offsets_at = file.size(), counts_at = offsets_at + offsets.size(),
                          text_at = counts_at + counts.size();
      file += offsets + counts + description + std::string(1, '\0');
      const std::uint64_t resolution_at = file.size();
      file += number(static_cast<std::uint64_t>(pixels_per_cm * 1000), 4) + number(1000, 4);
      std::map<int, std::string> entries;
      const auto add = [&](int tag, int type, std::uint64_t count, std::uint64_t value, int bytes) {
        const std::string text = number(value, bytes);
        entries[tag] = number(static_cast<std::uint64_t>(tag), 2) + number(static_cast<std::uint64_t>(type), 2) +
                       number(count, offset) + text + std::string(static_cast<std::size_t>(offset) - text.size(), '\0');
      };
      const auto list = [&](int tag, std::uint64_t at, const std::string& numbers) {
        const int type = is_bigtiff ? 16 : 4;
        if (parts.size() == 1) {
          add(tag, type, 1, tag == 273 || tag == 324 ? at - unlisted.size() - parts[0].size() : parts[0].size(), offset);
        } else {
          add(tag, type, numbers.size() / static_cast<std::size_t>(offset), at, offset);
        }
      };
      add(256, 4, 1, static_cast<std::uint64_t>(columns), 4), add(257, 4, 1, static_cast<std::uint64_t>(rows), 4);
      add(258, 3, 1, static_cast<std::uint64_t>(bits), 2), add(259, 3, 1, deflated ? 8 : 1, 2), add(262, 3, 1, 1, 2);
      if (!description.empty()) add(270, 2, description.size() + 1, text_at, offset);
      if (tile > 0) {
        add(322, 4, 1, static_cast<std::uint64_t>(tile), 4), add(323, 4, 1, static_cast<std::uint64_t>(tile), 4);
        list(324, offsets_at, offsets), list(325, counts_at, counts);
      } else {
        add(278, 4, 1, static_cast<std::uint64_t>(rows_per_strip), 4);
        list(273, offsets_at, offsets), list(279, counts_at, counts);
      }
      if (pixels_per_cm > 0) add(282, 5, 1, resolution_at, offset), add(283, 5, 1, resolution_at, offset), add(296, 3, 1, 3, 2);
      add(339, 3, 1, static_cast<std::uint64_t>(format), 2);
      for (const auto& [tag, value] : also) add(tag, 4, 1, value, 4);
      if (file.size() % 2 == 1) file += '\0';
      file.replace(link, static_cast<std::size_t>(offset), number(file.size(), offset));
      file += number(entries.size(), is_bigtiff ? 8 : 2);
      for (const auto& [tag, entry] : entries) file += entry;
      link = file.size();
      file += number(0, offset);
    }
    return file;
  }
};

/// A folder of files with an image each, whose numbers count from 8, by one more digit on the way.
inline void write_tiff_stack(const fs::path& folder, TiffToWrite tiff, const TemporaryFolder& in) {
  fs::create_directories(folder);
  const std::int64_t images = tiff.images;
  tiff.images = 1;
  for (tiff.first_image = 0; tiff.first_image < images; ++tiff.first_image)
    in.write(folder.filename().string() + "/slice" + std::to_string(8 + tiff.first_image) + ".tif", tiff.bytes());
}

}  // namespace palpa::test
