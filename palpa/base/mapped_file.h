// Memory-mapped files, for files too large to copy.
#pragma once

#include <cstddef>
#include <cstdint>

#include "palpa/base/input_file.h"

namespace palpa::detail {

/// Read-only mapping of a file for the lifetime of this object. If the file is truncated meanwhile, or its disk fails, lost
/// bytes read as zeros: SIGBUS for these bytes is caught; one line on standard error and `is_whole` report it. Other SIGBUS go
/// to the handler before the first mapping.
class MappedFile {
 public:
  /// Throws LoadError with a sentence if memory is short.
  explicit MappedFile(const InputFile& file);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  const std::byte* data() const noexcept { return data_; }
  std::uint64_t bytes() const noexcept { return bytes_; }
  /// False if the file was truncated, or bytes read could not be loaded. Any thread.
  bool is_whole() const noexcept;

 private:
  const std::byte* data_ = nullptr;
  std::uint64_t bytes_ = 0;
  int descriptor_ = -1;
  std::size_t place_ = 0;  ///< index in the signal handler's table
};

}  // namespace palpa::detail
