// Zarr arrays of tests: written without any library of Zarr, in versions 2 and 3, with shards.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "files.h"

namespace palpa::test {

/// Array to be written. Numbers are little-endian.
struct ZarrToWrite {
  int format = 2;
  std::vector<std::int64_t> shape, chunk;
  std::vector<std::int64_t> shard{};  ///< empty: none; version 3 only
  std::string type = "uint8";         ///< or "int16", "uint16", "float32", "float64"
  std::string codec = "raw";          ///< or "gzip", "zlib" (version 2), "zstd", "blosc"
  bool has_checksum = false;          ///< crc32c of each chunk; version 3 only
  bool index_at_end = true;
  std::string fill = "0";  ///< JSON
  std::function<double(const std::vector<std::int64_t>& at)> value;
  std::function<bool(const std::vector<std::int64_t>& chunk)> has_chunk = [](const auto&) { return true; };
};

void write_zarr_array(const fs::path& folder, const ZarrToWrite& array);
void write_text_file(const fs::path& file, const std::string& text);

/// Attributes of an image with axes z, y, x in micrometres and these octaves, whose scale is 1, 2, 4 …
/// \param halves  translations of (2ⁿ − 1) / 2, as of means
std::string multiscales(int octaves, bool halves, const std::string& version = "0.4");
/// Metadata of a group with attributes, in the folder.
void write_zarr_group(const fs::path& folder, const std::string& attributes, int format = 2);

/// An image of octaves 0 to 2, of means of `value` at octave 0, in chunks of 16 × 16 × 16.
/// \param side  [voxels] of octave 0
void write_zarr_image(const fs::path& folder, std::int64_t side, int format, const std::string& codec,
                      const std::function<double(std::int64_t i, std::int64_t j, std::int64_t k)>& value);

}  // namespace palpa::test
