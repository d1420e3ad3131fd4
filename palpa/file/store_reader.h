// Reading of chunks of an OME-Zarr store, by the sandboxed program palpa-read-zarr.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "palpa/file/read_volume.h"
#include "palpa/file/store_contents.h"

namespace palpa {

namespace detail {
class ReaderProcess;
}

/// Chunk that was read into a slot.
struct StoreRead {
  StoreChunk chunk;
  int slot = 0;
  ChunkState state = ChunkState::present;
  std::uint64_t bytes = 0;  ///< read from the store
  std::string sentence;     ///< of a damaged chunk: file in the store, and what is wrong with it
};

/// Open store: a palpa-read-zarr that decodes chunks into shared slots, as long as this object lives. The program parses all
/// metadata and chunks; it is sandboxed as palpa-read is, with a limit of computing per chunk. One thread.
class StoreReader {
 public:
  /// Starts the program and reads the metadata. Throws LoadError with one line: `STORE: what is wrong; what would be right`.
  /// \param slots  [1] chunks in memory at once, 1 or more
  StoreReader(const std::filesystem::path& store, const ReadOptions& options, int slots);
  /// Goes on with a program that has sent the header of a file, which it reads by rows. Throws LoadError as above.
  /// \param contents  `protocol::contents_by_rows` of that header, with an octave
  StoreReader(const std::filesystem::path& file, const ReadOptions& options, int slots,
              std::unique_ptr<detail::ReaderProcess> process, StoreContents contents);
  ~StoreReader();
  StoreReader(const StoreReader&) = delete;
  StoreReader& operator=(const StoreReader&) = delete;

  const StoreContents& contents() const noexcept;
  int slots() const noexcept;

  /// Requests a chunk into a slot that has no request pending. Throws LoadError if the program has ended.
  void request(const StoreChunk& chunk, int slot);
  /// Next chunk that was read, in any order; none after `timeout_s` [s] without one. Throws LoadError if the program has ended,
  /// and ends it if it makes no progress for `ReadOptions::idle_limit_s`.
  std::optional<StoreRead> next(double timeout_s);
  /// Content of a slot whose chunk has been read and is not absent: voxels of the whole chunk, i fastest, components of a voxel
  /// together, of the field's `type`; beyond the octave's last voxel they are unspecified. Of facts: a ChunkFacts for each
  /// chunk, i fastest; of presence: a byte for each, 1 where the store has any of its components, else 0. Shared with the sandboxed program, which could still change it: copy it, then check the copy.
  std::span<const std::byte> content(int slot) const noexcept;
  /// File descriptor that is readable when a chunk may be ready, for poll.
  int descriptor() const noexcept;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace palpa
