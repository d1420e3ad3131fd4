// Memory for palpa-read's voxels, on the caller's side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "palpa/file/protocol_memory.h"

namespace palpa::detail {

/// Memory shared by descriptors, immutable once sealed and mapped. Its size is fixed from the start, so that no read of ours
/// can fail.
class SharedMemory {
 public:
  /// \param bytes  [bytes] > 0. Throws LoadError with a sentence.
  explicit SharedMemory(std::uint64_t bytes);
  ~SharedMemory();
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;

  const protocol::MemoryFiles& files() const noexcept { return files_; }

  /// Voxels, read-only. Call after the reader's end: the seal fails with a writable mapping left. Throws LoadError with a
  /// sentence.
  std::shared_ptr<const std::byte> sealed_and_mapped();

 private:
  void make(int& file, std::uint64_t bytes);
  void close() noexcept;

  std::uint64_t bytes_;
  protocol::MemoryFiles files_;
};

/// Growing memory file for the content of a compressed file, during its reading.
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
