// The memory that palpa-read fills with voxels, on the side that made it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "palpa/file/protocol_memory.h"

namespace palpa::detail {

/// Made here, shared by descriptors, and once sealed and mapped nobody's to change. It can neither shrink nor grow from the
/// start, so that no read of ours can miss it.
class SharedMemory {
 public:
  /// \param bytes  [bytes] not 0. Throws LoadError with a sentence.
  explicit SharedMemory(std::uint64_t bytes);
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  const protocol::MemoryFiles& files() const noexcept { return files_; }

  /// The voxels, read-only. Call when the reader is gone: a seal against writing needs that nobody can. Throws LoadError with a
  /// sentence.
  std::shared_ptr<const std::byte> sealed_and_mapped();

 private:
  void make(int& file, std::uint64_t bytes);
  void close() noexcept;

  std::uint64_t bytes_;
  protocol::MemoryFiles files_;
};

/// A file of memory that grows, for what a packed file holds: only while it is read.
class UnpackedMemory {
 public:
  /// Throws LoadError with a sentence.
  UnpackedMemory();
  ~UnpackedMemory();
  UnpackedMemory(const UnpackedMemory&) = delete;
  UnpackedMemory& operator=(const UnpackedMemory&) = delete;
  int file() const noexcept { return file_; }

 private:
  int file_;
};

}  // namespace palpa::detail
