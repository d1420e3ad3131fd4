// CRC-32 of rows of voxels.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace palpa::detail {

/// CRC-32 of bytes that are added in short rows. They are gathered in pieces: zlib takes six times as long for rows of 32 bytes
/// as for whole chunks. Allocates nothing; one thread.
class RowCrc {
 public:
  void add(const void* row, std::size_t bytes) noexcept;
  /// Of all bytes that were added.
  std::uint32_t value() noexcept;

 private:
  void flush() noexcept;

  std::uint32_t crc_ = 0;
  std::size_t filled_ = 0;
  std::array<unsigned char, 8192> piece_;
};

}  // namespace palpa::detail
