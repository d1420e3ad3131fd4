// Files that are too large to be copied.
#pragma once

#include <cstddef>
#include <cstdint>

#include "palpa/base/input_file.h"

namespace palpa::detail {

/// All of a file in memory, read-only, for as long as this object lives. Where somebody cuts the file short meanwhile, or its
/// disk fails, what is gone reads as zeros: the signal that would end the process (SIGBUS) is caught for these bytes, one line
/// on standard error says so, and so does `is_whole`. All other such signals go where they went before the first file was
/// mapped.
class MappedFile {
 public:
  /// Throws LoadError with a sentence where there is no room for it.
  explicit MappedFile(const InputFile& file);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  const std::byte* data() const noexcept { return data_; }
  std::uint64_t bytes() const noexcept { return bytes_; }
  /// False where the file is shorter than it was, or bytes have been read that could not be had. Any thread.
  bool is_whole() const noexcept;

 private:
  const std::byte* data_ = nullptr;
  std::uint64_t bytes_ = 0;
  int descriptor_ = -1;
  std::size_t place_ = 0;  ///< among those that the signal's handler knows
};

}  // namespace palpa::detail
