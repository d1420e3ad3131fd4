// Shared memory for voxels: made by the caller, filled by palpa-read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace palpa::protocol {

/// Memory files (memfd_create) mapped contiguously. A large memory has two: the system serialises writes to a file, which would
/// take longer than to read most files.
struct MemoryFiles {
  int first = -1;
  int second = -1;  ///< -1 if the first holds all
};

/// Bytes in the first file of a memory of `bytes`: all, or half of a large one, in whole pages.
std::uint64_t bytes_in_first(std::uint64_t bytes) noexcept;

struct Memory {
  MemoryFiles files;
  std::uint64_t bytes = 0;
  std::shared_ptr<std::byte> all;

  /// Copies into it through its files: a page fault per page takes longer than a copy. Thread-safe for disjoint ranges.
  void write(std::byte* place, const std::byte* from, std::uint64_t count) const;
};

/// Maps a memory of `bytes` > 0. Throws std::bad_alloc without address space, and LoadError if a file is missing or too short.
Memory mapped(const MemoryFiles& files, std::uint64_t bytes, bool writable);

}  // namespace palpa::protocol
