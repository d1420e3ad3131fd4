// Voxels of a store, read when they are needed.
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "palpa/data/octaves.h"
#include "palpa/file/store_reader.h"

namespace palpa::detail {

/// Chunks of an open store, the last used ones kept in memory. Any number of threads, one at a time.
class StoreCache {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  /// \param most_bytes  of chunks that are kept
  StoreCache(std::unique_ptr<StoreReader> reader, std::uint64_t most_bytes);

  const StoreContents& contents() const noexcept { return reader_->contents(); }
  StoreReader& reader() noexcept { return *reader_; }
  /// Contents of chunks of one field, frame and octave; null for chunks that are lost or damaged, or not as prepared. Of an
  /// absent chunk the fill value. Blocks. Throws LoadError if the reader has ended.
  std::vector<Bytes> chunks(const std::vector<StoreChunk>& wanted);

 private:
  struct Kept {
    Bytes bytes;
    std::list<StoreChunk>::iterator place;
  };
  void read(const std::vector<StoreChunk>& missing);
  Bytes checked(const StoreRead& read, std::span<const std::byte> content);
  const ChunkFacts* facts_of(const StoreChunk& chunk) const;
  void read_facts(const std::vector<StoreChunk>& of);
  Bytes filled(const StoreChunk& chunk) const;
  void keep(const StoreChunk& chunk, Bytes bytes);

  std::mutex busy_;
  std::unique_ptr<StoreReader> reader_;
  std::uint64_t most_bytes_, bytes_ = 0;
  std::list<StoreChunk> used_;  ///< the last used first
  std::map<StoreChunk, Kept> kept_;
  std::map<StoreChunk, std::vector<ChunkFacts>> facts_;  ///< chunks of facts
};

/// Field of a store at a frame.
class StoreVoxels final : public VoxelSource {
 public:
  StoreVoxels(std::shared_ptr<StoreCache> cache, std::int32_t field, std::int32_t frame)
      : cache_(std::move(cache)), field_(field), frame_(frame) {}
  bool read(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims,
            std::byte* to) override;

 private:
  std::shared_ptr<StoreCache> cache_;
  std::int32_t field_, frame_;
};

}  // namespace palpa::detail
