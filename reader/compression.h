// Compressed data: checks of their checksum and length; decompression.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace palpa::reader {

/// Decompresses the zlib or gzip stream from byte `offset` of a file to its checksum; keeps nothing. Throws LoadError, with a
/// sentence, if the stream is incomplete or damaged.
void check_compression(const std::string& path, std::uint64_t offset);

/// Throws LoadError if the stream, or several in sequence, cannot hold `bytes` bytes. Decompresses them to count only if that
/// is an unusually high ratio.
void check_claim(const std::string& path, std::uint64_t offset, std::uint64_t bytes);

/// Reads `bytes` bytes from `offset` on, of the file or, if it is compressed by gzip, of its decompressed content. Throws
/// LoadError, with a sentence, if there are fewer.
void read_unpacked(const std::string& path, std::uint64_t offset, std::byte* to, std::uint64_t bytes);

/// Decompresses `bytes` bytes from the zlib or gzip streams that begin at byte `offset` of a file. Throws LoadError, with a
/// sentence, if there are fewer.
void unpack(const std::string& path, std::uint64_t offset, std::byte* to, std::uint64_t bytes);

/// Decompresses a gzip file into a memory file. Throws LoadError, with a sentence, if it is damaged, incomplete, or holds more
/// than `most` bytes.
void unpack_whole(const std::string& path, int to, std::uint64_t most);

/// Replaces the content of a memory file by the first `start` bytes of `beginning` and the decompressed rest of the file.
/// Throws LoadError, with a half sentence, in the cases above.
void unpack_rest(const std::string& path, const std::string& beginning, int to, std::uint64_t most);

}  // namespace palpa::reader
