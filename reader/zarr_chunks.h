// Chunks of an array in its files, also those of shards.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "palpa/file/store_protocol.h"
#include "zarr_array.h"

namespace palpa::reader {

/// Outcome of reading a chunk.
struct ZarrRead {
  ChunkState state = ChunkState::present;
  std::uint64_t bytes = 0;  ///< read from the store
  std::string sentence{};   ///< of a damaged chunk: "'0/1/2': does not decompress (blosc)"
};

/// Reader of the chunks of a store's arrays, with the indices of the shards read last. Any number of threads.
class ZarrChunks {
 public:
  explicit ZarrChunks(const ZarrFolder& folder) : folder_(folder) {}

  /// Reads the chunk with this index, in chunks along each axis, into `to`, of `array.chunk_bytes()`. `packed` is scratch
  /// memory. Throws bad_alloc only.
  ZarrRead read(const ZarrArray& array, std::span<const std::int64_t> at, std::vector<std::byte>& packed,
                std::span<std::byte> to) const;

  struct ShardIndex;
  /// Shards that were looked at, by their names; null for absent ones.
  using KnownShards = std::map<std::string, std::shared_ptr<const ShardIndex>>;
  /// Whether the store has the chunk with this index, by its file or its shard's index; decodes nothing. Throws LoadError on a
  /// damaged shard, and bad_alloc.
  bool has(const ZarrArray& array, std::span<const std::int64_t> at, KnownShards& known) const;

 private:
  struct Piece {
    std::uint64_t offset = 0, bytes = 0;
  };
  static std::string file_of(const ZarrArray& array, std::span<const std::int64_t> at);
  static std::size_t position_of(const ZarrArray& array, std::span<const std::int64_t> at) noexcept;
  std::shared_ptr<const ZarrFile> opened(const ZarrArray& array, const std::string& name) const;
  std::shared_ptr<const ShardIndex> index_of(const ZarrArray& array, const std::string& name, const ZarrFile& file) const;
  Piece piece_of(const ZarrArray& array, std::span<const std::int64_t> at, const std::string& name, const ZarrFile& file) const;

  const ZarrFolder& folder_;
  mutable std::mutex mutex_;
  mutable std::list<std::shared_ptr<const ShardIndex>> indices_;  ///< the latest first
};

/// Places of the chunks in a shard.
struct ZarrChunks::ShardIndex {
  std::string file;
  std::uint64_t bytes = 0;
  timespec changed{};
  std::vector<Piece> pieces;
};

}  // namespace palpa::reader
