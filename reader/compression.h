// Compressed data: checks that they are whole, by their own checksum, and as many as a header says; plain reading.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace palpa::reader {

/// Unpacks the zlib or gzip stream that begins at byte `offset` of a file to its end, where its checksum
/// lies; keeps nothing. Throws LoadError, with a sentence, unless the stream is whole and undamaged.
void check_compression(const std::string& path, std::uint64_t offset);

/// Throws LoadError where the stream, or several one after the other, cannot hold `bytes` bytes. Unpacks them to count only if
/// that would be unusually many for the length of the file.
void check_claim(const std::string& path, std::uint64_t offset, std::uint64_t bytes);

/// Reads `bytes` bytes from `offset` on of a file, or, where it is compressed by gzip, of what it holds. Throws LoadError, with
/// a sentence, where there are fewer.
void read_unpacked(const std::string& path, std::uint64_t offset, std::byte* to, std::uint64_t bytes);

/// Reads `bytes` bytes of what the zlib or gzip stream that begins at byte `offset` of a file holds, or several one after the
/// other. Throws LoadError, with a sentence, where there are fewer.
void unpack(const std::string& path, std::uint64_t offset, std::byte* to, std::uint64_t bytes);

/// Writes what a file that is packed by gzip holds to a file of memory. Throws LoadError, with a sentence, where it is damaged,
/// not whole, or holds more than `most` bytes.
void unpack_whole(const std::string& path, int to, std::uint64_t most);

/// Writes the first `start` bytes of a file, as `beginning` has them, and what the deflated rest of it holds to a file of
/// memory, in place of all that is there. Throws LoadError, with a half sentence, as above.
void unpack_rest(const std::string& path, const std::string& beginning, int to, std::uint64_t most);

}  // namespace palpa::reader
