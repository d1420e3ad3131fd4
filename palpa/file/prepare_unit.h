// Threads that make units of a store, and their files.
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "palpa/file/prepare_store.h"
#include "palpa/file/store_histogram.h"
#include "palpa/file/unit_walk.h"

namespace palpa::detail {

/// Facts of a box of chunks of each octave.
class FactsBox {
 public:
  /// \param first, size  [chunks] of each octave; no size: the octave is left out
  void set(int octave, const VoxelIndex& first, const VoxelIndex& size);
  /// Facts of a chunk; nullptr outside of the box. Threads may write to different chunks.
  ChunkFacts* at(int octave, const VoxelIndex& chunk) noexcept;

 private:
  struct Part {
    VoxelIndex first{}, size{};
    std::vector<ChunkFacts> facts;
  };
  std::vector<Part> octaves_;
};

/// Chunk that was packed.
struct PackedChunk {
  int octave = 0, channel = 0;
  VoxelIndex at{};  ///< [chunks]
  std::vector<std::byte> bytes;
};

/// Writer of the arrays of a preparation. Any thread, but for shards.
class PreparedFiles {
 public:
  PreparedFiles(const UnitPlan& plan, const std::filesystem::path& target);

  /// Writes the metadata of all arrays.
  void make();
  bool is_done(const UnitPlan::Item& item) const;
  void write(int frame, const PackedChunk& chunk, FileBatch& batch);
  bool has_shards(int octave) const;
  /// Appends to the open shard; those of a unit are finished together. One thread at a time.
  void append(int frame, const PackedChunk& chunk);
  void finish_shards(FileBatch& batch);
  /// Writes the facts of an octave in a box. \param first, end  [chunks of facts]
  void write_facts(int octave, int frame, int field, const VoxelIndex& first, const VoxelIndex& end, FactsBox& facts,
                   FileBatch& batch);
  void write_histogram(const UnitPlan::Item& item, const DyadicHistogram& histogram, FileBatch& batch);
  /// Of a unit; none where the file is missing. Throws LoadError "FILE: problem; remedy".
  std::optional<DyadicHistogram> histogram(const UnitPlan::Item& item) const;
  std::int64_t written() const noexcept { return written_; }

 private:
  std::vector<std::int64_t> place(int frame, int channel, const VoxelIndex& at) const;

  const UnitPlan& plan_;
  std::map<int, ArrayFiles> voxels_, facts_;
  ArrayFiles histograms_;
  std::map<std::tuple<int, int, std::vector<std::int64_t>>, ShardFile> shards_;  ///< octave, channel, place
  std::atomic<std::int64_t> written_ = 0;
};

/// A thread's reader and walk.
struct UnitWorker {
  std::unique_ptr<StoreReader> reader, compared;  ///< `compared`: of a check
  std::unique_ptr<ChunkStream> stream;
  std::unique_ptr<UnitWalk> walk;
  FileBatch batch;
  DyadicHistogram histogram;        ///< of the unit's voxels
  std::vector<PackedChunk> packed;  ///< of the task, for shards
};

/// Numbers of a type that only files have; empty: as in memory.
std::vector<std::byte> narrowed(StoredAs stored, std::span<const std::byte> voxels);

/// Calls `act(worker, number)` for all numbers below `count`, on `workers` threads. Rethrows the first exception.
void on_workers(int workers, std::int64_t count, const std::function<void(int, std::int64_t)>& act);

/// [1] slots of a reader for a store's chunks.
int reader_slots(const UnitPlan& plan);

}  // namespace palpa::detail
