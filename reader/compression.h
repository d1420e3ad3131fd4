// Whether compressed data are whole, by their own checksum.
#pragma once

#include <cstdint>
#include <string>

namespace palpa::reader {

/// Unpacks the zlib or gzip stream that begins at byte `offset` of a file to its end, where its checksum
/// lies; keeps nothing. Throws LoadError, with a sentence, unless the stream is whole and undamaged.
void check_compression(const std::string& path, std::uint64_t offset);

}  // namespace palpa::reader
