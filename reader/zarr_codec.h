// Decoding of a chunk's bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "zarr_array.h"

namespace palpa::reader {

/// CRC-32C of bytes, as in codecs of Zarr 3. Allocates nothing; any thread.
std::uint32_t crc32c_of(std::span<const std::byte> bytes) noexcept;

/// Most bytes that a chunk of this size has in a file: more are damage.
std::uint64_t most_packed_bytes(std::uint64_t chunk_bytes) noexcept;

/// Decodes a chunk into `to`, which it fills exactly. Decoders write nowhere else. Allocates; any thread.
/// \return  fault as half a sentence; empty: none
std::string decode_chunk(const std::vector<ZarrCodec>& codecs, std::span<const std::byte> packed, std::span<std::byte> to);

}  // namespace palpa::reader
