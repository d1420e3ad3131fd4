// Metadata of one Zarr array, version 2 or 3.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "palpa/file/protocol_voxels.h"
#include "zarr_folder.h"

namespace palpa::reader {

/// Type of an array's numbers.
struct ZarrType {
  std::string name;                                  ///< "int16"
  protocol::RawType raw = protocol::RawType::uint8;  ///< of the file; uint16 for float16
  bool half = false;                                 ///< float16
  bool swapped = false;                              ///< byte order opposite to this machine's
  VoxelType delivered = VoxelType::uint8;            ///< the file's, or the next wider one
  std::size_t bytes() const noexcept { return protocol::size_of(raw); }
};

/// Step from the bytes of a file towards those of a chunk.
enum class ZarrCodec : std::uint8_t { blosc, zlib, gzip, zstd, crc32c };

struct ZarrArray {
  std::string path{};  ///< in the store; empty: the store itself
  int format = 2;      ///< of Zarr
  std::vector<std::int64_t> shape{};
  std::vector<std::int64_t> chunk{};   ///< [numbers] decoded at once
  std::vector<std::int64_t> shard{};   ///< [numbers] of a file; equal to `chunk` without shards
  std::vector<std::int64_t> stride{};  ///< [numbers] within a chunk
  std::vector<std::string> axes{};     ///< names of the indices, by the array itself; empty: none
  ZarrType type{};
  double fill = 0.0;                ///< value of an absent chunk
  std::vector<ZarrCodec> codecs{};  ///< of a chunk, in the order of decoding
  std::string codec_words = "not compressed";
  bool has_shards = false, index_at_end = true, index_has_checksum = false;
  std::string prefix{};  ///< of a file's name below `path`: "c/" or empty
  char separator = '.';

  std::uint64_t chunk_numbers() const noexcept;
  std::uint64_t chunk_bytes() const noexcept { return chunk_numbers() * type.bytes(); }
  /// [1] Chunks in a file.
  std::uint64_t chunks_in_file() const noexcept;
  /// Path in the store of the file with this index, in files along each axis. Allocates.
  std::string file_of(std::span<const std::int64_t> at) const;
};

/// Reads `path`/.zarray or `path`/zarr.json. Throws LoadError with a sentence: no such array, or one that is not read.
/// \param most_chunk_bytes  larger chunks are refused
ZarrArray read_zarr_array(const ZarrFolder& folder, const std::string& path, std::uint64_t most_chunk_bytes);

}  // namespace palpa::reader
