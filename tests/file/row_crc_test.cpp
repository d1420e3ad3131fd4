// CRC-32 of rows: that of all bytes, however they are cut.
#include "palpa/file/row_crc.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <span>
#include <string_view>
#include <vector>

namespace palpa::detail {
namespace row_crc_test {

/// By the definition: division of polynomials, bit by bit.
std::uint32_t crc_by_bits(std::span<const unsigned char> bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const unsigned char byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  return ~crc;
}

TEST(RowCrc, IsThatOfAllBytesHoweverTheyAreCut) {
  std::mt19937 random(1);
  for (const std::size_t longest : {1u, 32u, 5000u, 20000u}) {
    std::vector<unsigned char> bytes(50000);
    for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
    RowCrc crc;
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t row = std::min<std::size_t>(1 + random() % longest, bytes.size() - at);
      crc.add(&bytes[at], row);
      at += row;
    }
    EXPECT_EQ(crc.value(), crc_by_bits(bytes)) << longest;
  }
  RowCrc known;
  const std::string_view check = "123456789";
  known.add(check.data(), check.size());
  EXPECT_EQ(known.value(), 0xcbf43926u);
  EXPECT_EQ(RowCrc().value(), 0u);
}

}  // namespace row_crc_test
}  // namespace palpa::detail
