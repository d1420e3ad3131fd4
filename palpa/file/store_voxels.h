// Voxels of a store, read when they are needed.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "palpa/data/octaves.h"
#include "palpa/file/store_chunks.h"
#include "palpa/file/store_reader.h"

namespace palpa::detail {

/// Chunks of an open store, the last used ones kept in memory. Any number of threads, one at a time.
class StoreCache {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::byte>>;
  using Open = std::function<std::unique_ptr<StoreReader>()>;
  /// \param name        of the store, for sentences
  /// \param reader      of the store
  /// \param open        opens it once more, if the reader has ended
  /// \param most_bytes  of chunks that are kept
  StoreCache(std::string name, std::unique_ptr<StoreReader> reader, Open open, std::uint64_t most_bytes);

  const StoreContents& contents() const noexcept { return contents_; }
  /// Cache of the store with a reader, chunks and checksums of its own. Blocks; throws LoadError.
  std::shared_ptr<StoreCache> beside(std::uint64_t most_bytes) const;
  /// Contents of chunks of one field, frame and octave; null for chunks that are lost, damaged, not as prepared, or not as they
  /// were read before. Of an absent chunk the fill value; without facts it is lost where the next octave has other values.
  /// Blocks. A reader that has ended is started once more; throws LoadError at its second end.
  std::vector<Bytes> chunks(const std::vector<StoreChunk>& wanted);

  /// As `VoxelSource`, of a frame of a field.
  std::vector<ChunkSum> sums_from(std::int32_t field, std::int32_t frame, std::size_t from) const;
  void expect(std::int32_t field, std::int32_t frame, const std::vector<ChunkSum>& sums);
  std::vector<std::string> problems_from(std::size_t from) const;

 private:
  struct Kept {
    Bytes bytes;
    std::list<StoreChunk>::iterator place;
  };
  std::unique_ptr<StoreReader> opened_again() const;
  void read(const std::vector<StoreChunk>& wanted);
  void read_missing(const std::vector<StoreChunk>& wanted);
  void drop_lost(const std::vector<StoreChunk>& absent);
  bool is_filled_in_next_octave(const StoreChunk& chunk);
  Bytes checked(const StoreRead& read, std::span<const std::byte> content);
  Bytes refused(const StoreChunk& chunk, const std::string& reason);
  [[noreturn]] void refuse_recorded(const StoreChunk& chunk) const;
  bool is_as_before(const StoreChunk& chunk, std::uint32_t crc32);
  const ChunkFacts* facts_of(const StoreChunk& chunk) const;
  void read_facts(const std::vector<StoreChunk>& of);
  Bytes filled(const StoreChunk& chunk) const;
  void keep(const StoreChunk& chunk, Bytes bytes);

  std::mutex busy_;  ///< of all but the next four
  mutable std::mutex sums_busy_;
  std::map<StoreChunk, std::uint32_t> first_sums_;
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<ChunkSum>> sums_;  ///< by field and frame, as first read
  std::vector<std::string> problems_;
  bool expects_ = false;  ///< the first sums are those of a recording
  std::string name_;
  std::unique_ptr<StoreReader> reader_;
  StoreContents contents_;
  Open open_;
  bool was_reopened_ = false;
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
  std::vector<ChunkSum> sums_from(std::size_t from) const override { return cache_->sums_from(field_, frame_, from); }
  void expect(const std::vector<ChunkSum>& sums) override { cache_->expect(field_, frame_, sums); }
  std::vector<std::string> problems_from(std::size_t from) const override { return cache_->problems_from(from); }
  std::shared_ptr<VoxelSource> beside() const override;

 private:
  bool copy_chunks(const std::vector<StoreChunk>& wanted, const VoxelBox& box, std::byte* to);

  std::shared_ptr<StoreCache> cache_;
  std::int32_t field_, frame_;
};

}  // namespace palpa::detail
