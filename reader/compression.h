// Checks that compressed data are whole, by their own checksum, and as many as a header says.
#pragma once

#include <cstdint>
#include <string>

namespace palpa::reader {

/// Unpacks the zlib or gzip stream that begins at byte `offset` of a file to its end, where its checksum
/// lies; keeps nothing. Throws LoadError, with a sentence, unless the stream is whole and undamaged.
void check_compression(const std::string& path, std::uint64_t offset);

/// Throws LoadError where the stream, or several one after the other, cannot hold `bytes` bytes. Unpacks them to count only if
/// that would be unusually many for the length of the file.
void check_claim(const std::string& path, std::uint64_t offset, std::uint64_t bytes);

}  // namespace palpa::reader
