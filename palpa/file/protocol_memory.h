// The memory that voxels come in: made by the caller, filled by palpa-read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace palpa::protocol {

/// Files of memory (memfd_create) that are mapped one behind the other. A large memory is two: the system lets one thread at a
/// time write to a file, and that takes longer than to read most files of others.
struct MemoryFiles {
  int first = -1;
  int second = -1;  ///< -1 where the first holds all
};

/// How much of a memory of `bytes` the first of its files holds: all, or half of a large one, in whole pages.
std::uint64_t bytes_in_first(std::uint64_t bytes) noexcept;

/// A memory, mapped.
struct Memory {
  MemoryFiles files;
  std::uint64_t bytes = 0;
  std::shared_ptr<std::byte> all;

  /// Copies to a place in it, through its files: a fault for every page takes longer than a copy. Thread-safe for places that
  /// do not overlap.
  void write(std::byte* place, const std::byte* from, std::uint64_t count) const;
};

/// Maps a memory of `bytes`, which is not 0. Throws std::bad_alloc where there is no address space, and LoadError where a file
/// is missing or too short.
Memory mapped(const MemoryFiles& files, std::uint64_t bytes, bool writable);

}  // namespace palpa::protocol
