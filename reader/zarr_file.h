// An open file of a Zarr store, on a disk or fetched.
#pragma once

#include <cstddef>
#include <cstdint>
#include <ctime>

namespace palpa::reader {

class ZarrFile {
 public:
  ZarrFile() = default;
  virtual ~ZarrFile() = default;
  ZarrFile(const ZarrFile&) = delete;
  ZarrFile& operator=(const ZarrFile&) = delete;

  virtual std::uint64_t bytes() const noexcept = 0;
  /// As `InputFile::read`; any thread.
  virtual std::size_t read(std::uint64_t from, void* to, std::size_t bytes) const = 0;
  /// Time of the last change; 0 if unknown.
  virtual std::timespec changed() const noexcept { return {}; }
};

}  // namespace palpa::reader
