// Arrays of a Zarr store that are written: metadata, chunks and shards.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "palpa/base/new_file.h"
#include "palpa/data/grid.h"

namespace palpa::detail {

/// Type of numbers in a file, where Palpa has none in memory.
enum class StoredAs : std::uint8_t {
  as_in_memory,
  int8,    ///< of int16 in memory
  uint32,  ///< of float64 in memory
};
/// [bytes] of a number in a file. \param type  in memory
std::size_t stored_bytes(StoredAs stored, VoxelType type) noexcept;

/// Array of a store. Indices and lengths slowest first.
struct ArrayPlan {
  int zarr = 2;      ///< version of Zarr: 2, or 3
  std::string path;  ///< in the store: "0", "palpa/facts/0"
  VoxelType type = VoxelType::uint8;
  StoredAs stored = StoredAs::as_in_memory;
  std::vector<std::int64_t> shape, chunk;
  std::vector<std::int64_t> shard{};  ///< a multiple of `chunk`; empty: a file for each chunk
  std::vector<std::string> axes{};    ///< names, of Zarr 3
  bool is_packed = true;              ///< by blosc; else chunks are bare numbers
};

/// Text of .zarray or zarr.json. Equal plans give equal bytes. Allocates; any thread.
std::string array_metadata(const ArrayPlan& plan);
/// Text of .zgroup, or of a zarr.json without attributes. Allocates; any thread.
std::string group_metadata(int zarr);

/// Voxels of a chunk, packed by blosc (lz4, bitshuffle). Equal voxels give equal bytes. Allocates; any thread. Throws
/// LoadError, without a place, if blosc fails. \param number_bytes  of one number
std::vector<std::byte> packed_chunk(std::span<const std::byte> voxels, std::size_t number_bytes);

/// Files that are written, synced and named together: one sync for many. One thread.
class FileBatch {
 public:
  FileBatch();
  /// Takes a file whose bytes are written. Throws LoadError as `finish`, when the batch is full.
  void add(std::unique_ptr<NewFile> file, const std::filesystem::path& name);
  /// Syncs the files and gives them their names. Throws LoadError "NAME: problem; remedy".
  void finish();

 private:
  std::size_t most_;
  std::vector<std::pair<std::unique_ptr<NewFile>, std::filesystem::path>> files_;
};

/// Raises this process's limit of open files to `count` and a few more, as far as the system allows. Any thread.
void allow_open_files(std::size_t count) noexcept;

/// Array in a store's folder. Any thread, a batch for each.
class ArrayFiles {
 public:
  /// Makes nothing yet. \param store  folder
  ArrayFiles(std::filesystem::path store, ArrayPlan plan);

  const ArrayPlan& plan() const noexcept { return plan_; }
  /// Makes the folders, and writes the metadata of the array and of the groups around it, unless the same bytes are there.
  /// Throws LoadError on other metadata, and on a folder that cannot be written.
  void make();
  /// File of a chunk or shard. \param at  [chunks, or shards]
  std::filesystem::path file(std::span<const std::int64_t> at) const;
  bool has(std::span<const std::int64_t> at) const;
  /// New file for a chunk or shard, with its folders.
  std::unique_ptr<NewFile> begin(std::span<const std::int64_t> at);
  /// Writes a chunk of an array without shards.
  void write(std::span<const std::int64_t> at, std::span<const std::byte> packed, FileBatch& batch);

 private:
  std::filesystem::path store_;
  ArrayPlan plan_;
  std::mutex mutex_;
  std::set<std::string> folders_;  ///< made already; under mutex_
};

/// Shard file: its chunks in the order of their writing, then the index. One thread.
class ShardFile {
 public:
  ShardFile(ArrayFiles& of, std::vector<std::int64_t> at);
  /// Appends a chunk. \param inside  [chunks] from the shard's first
  void append(std::span<const std::int64_t> inside, std::span<const std::byte> packed);
  /// Writes the index, and hands the file to the batch.
  void finish(FileBatch& batch);

 private:
  ArrayFiles& of_;
  std::vector<std::int64_t> at_, chunks_;
  std::unique_ptr<NewFile> file_;
  std::vector<std::uint64_t> index_;  ///< [bytes] offset and length of each chunk
  std::uint64_t end_ = 0;             ///< [bytes]
};

/// CRC-32C (Castagnoli) of bytes, of the index of a shard.
std::uint32_t crc32c(std::span<const std::byte> bytes) noexcept;

}  // namespace palpa::detail
