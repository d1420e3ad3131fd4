#include "zarr_codec.h"

#include <blosc.h>
#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <new>

namespace palpa::reader {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t checksum_bytes = 4;

/// Remainders of all bytes, and of these with 1 to 7 zero bytes behind.
constexpr std::array<std::array<std::uint32_t, 256>, 8> make_remainders() {
  std::array<std::array<std::uint32_t, 256>, 8> made{};
  constexpr std::uint32_t reversed_polynomial = 0x82f63b78U;
  for (std::uint32_t n = 0; n < 256; ++n) {
    std::uint32_t rest = n;
    for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1) ^ ((rest & 1) != 0 ? reversed_polynomial : 0);
    made[0][n] = rest;
  }
  for (std::size_t behind = 1; behind < 8; ++behind) {
    for (std::size_t n = 0; n < 256; ++n) {
      const std::uint32_t rest = made[behind - 1][n];
      made[behind][n] = (rest >> 8) ^ made[0][rest & 0xff];
    }
  }
  return made;
}
constexpr auto remainders = make_remainders();

std::string wrong_size(std::uint64_t there, std::uint64_t needed) {
  return "holds " + std::to_string(there) + " bytes where a chunk has " + std::to_string(needed);
}

std::string unpack_blosc(Bytes packed, std::span<std::byte> to) {
  std::size_t bytes = 0;
  if (blosc_cbuffer_validate(packed.data(), packed.size(), &bytes) != 0) return "has an invalid header of blosc";
  if (bytes != to.size()) return wrong_size(bytes, to.size());
  const int got = blosc_decompress_ctx(packed.data(), to.data(), to.size(), 1);
  return got == static_cast<int>(to.size()) ? std::string() : "does not decompress (blosc)";
}

/// \param window_bits  of zlib: 15 for its own format, 31 for gzip
std::string inflate_whole(Bytes packed, std::span<std::byte> to, int window_bits, const char* name) {
  z_stream stream{};
  if (inflateInit2(&stream, window_bits) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, inflateEnd);
  std::byte beyond{};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(to.data());
  stream.avail_out = static_cast<uInt>(to.size());
  int result = inflate(&stream, Z_FINISH);
  if (result == Z_BUF_ERROR && stream.avail_out == 0) {  // full, and the checksum is not read yet, or there is more
    stream.next_out = reinterpret_cast<Bytef*>(&beyond), stream.avail_out = 1;
    result = inflate(&stream, Z_FINISH);
    if (stream.avail_out == 0) return "holds more bytes than a chunk has";
  }
  if (result == Z_MEM_ERROR) throw std::bad_alloc();
  if (result != Z_STREAM_END) return std::string("does not decompress (") + name + ")";
  return stream.total_out == to.size() ? std::string() : wrong_size(stream.total_out, to.size());
}

std::string unpack_zstd(Bytes packed, std::span<std::byte> to) {
  const std::size_t got = ZSTD_decompress(to.data(), to.size(), packed.data(), packed.size());
  if (ZSTD_getErrorCode(got) == ZSTD_error_dstSize_tooSmall) return "holds more bytes than a chunk has";
  if (ZSTD_isError(got) != 0) return "does not decompress (zstd)";
  return got == to.size() ? std::string() : wrong_size(got, to.size());
}

std::string unpack(ZarrCodec codec, Bytes packed, std::span<std::byte> to) {
  switch (codec) {
    case ZarrCodec::blosc: return unpack_blosc(packed, to);
    case ZarrCodec::zlib: return inflate_whole(packed, to, 15, "zlib");
    case ZarrCodec::gzip: return inflate_whole(packed, to, 31, "gzip");
    case ZarrCodec::zstd: return unpack_zstd(packed, to);
    case ZarrCodec::crc32c: break;
  }
  return "has no such codec";
}

/// Removes a checksum behind bytes. Returns false if it is another.
bool take_checksum(Bytes& bytes) {
  if (bytes.size() < checksum_bytes) return false;
  const Bytes behind = bytes.last(checksum_bytes);
  bytes = bytes.first(bytes.size() - checksum_bytes);
  std::uint32_t stored = 0;
  for (std::size_t n = 0; n < checksum_bytes; ++n) stored |= static_cast<std::uint32_t>(behind[n]) << (8 * n);
  return stored == crc32c_of(bytes);
}

}  // namespace

std::uint32_t crc32c_of(std::span<const std::byte> bytes) noexcept {
  std::uint32_t rest = ~0U;
  const auto* at = reinterpret_cast<const std::uint8_t*>(bytes.data());
  std::size_t left = bytes.size();
  for (; left >= 8; at += 8, left -= 8) {
    std::uint32_t next = 0;
    for (std::size_t n = 0; n < 4; ++n) next ^= remainders[7 - n][static_cast<std::uint8_t>(at[n] ^ (rest >> (8 * n)))];
    for (std::size_t n = 4; n < 8; ++n) next ^= remainders[7 - n][at[n]];
    rest = next;
  }
  for (; left > 0; ++at, --left) rest = (rest >> 8) ^ remainders[0][(rest ^ *at) & 0xff];
  return ~rest;
}

std::uint64_t most_packed_bytes(std::uint64_t chunk_bytes) noexcept {
  constexpr std::uint64_t overhead_bytes = 1 << 16;
  return 2 * chunk_bytes + overhead_bytes;
}

std::string decode_chunk(const std::vector<ZarrCodec>& codecs, std::span<const std::byte> packed, std::span<std::byte> to) {
  std::vector<std::byte> room;  // of a chunk with the checksums that lie within its compression
  bool is_unpacked = false;
  for (std::size_t n = 0; n < codecs.size(); ++n) {
    if (codecs[n] == ZarrCodec::crc32c) {
      if (!take_checksum(packed)) return "has another checksum (crc32c)";
      continue;
    }
    const auto inner =
        static_cast<std::size_t>(std::count(codecs.begin() + static_cast<std::ptrdiff_t>(n), codecs.end(), ZarrCodec::crc32c));
    if (inner > 0) room.resize(to.size() + inner * checksum_bytes);
    const std::span<std::byte> into = inner > 0 ? std::span(room) : to;
    if (std::string fault = unpack(codecs[n], packed, into); !fault.empty()) return fault;
    packed = into;
    is_unpacked = inner == 0;
  }
  if (is_unpacked) return {};
  if (packed.size() != to.size()) return wrong_size(packed.size(), to.size());
  std::memcpy(to.data(), packed.data(), to.size());
  return {};
}

}  // namespace palpa::reader
