#include "palpa/file/row_crc.h"

#include <zlib.h>

#include <cstring>

namespace palpa::detail {

void RowCrc::add(const void* row, std::size_t bytes) noexcept {
  if (bytes > piece_.size() - filled_) flush();
  if (bytes > piece_.size()) {
    crc_ = static_cast<std::uint32_t>(::crc32_z(crc_, static_cast<const Bytef*>(row), bytes));
    return;
  }
  std::memcpy(piece_.data() + filled_, row, bytes);
  filled_ += bytes;
}

std::uint32_t RowCrc::value() noexcept {
  flush();
  return crc_;
}

void RowCrc::flush() noexcept {
  crc_ = static_cast<std::uint32_t>(::crc32_z(crc_, piece_.data(), filled_));
  filled_ = 0;
}

}  // namespace palpa::detail
