// Compressed data: checks of their checksum and length; decompression.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace palpa::reader {

/// Checks the zlib or gzip stream from byte `offset` of a file to its checksum. Throws LoadError, with a sentence, if it is
/// incomplete or damaged.
void check_compression(const std::string& path, std::uint64_t offset);

/// Throws LoadError if the streams from `offset` on cannot hold `bytes` bytes. Decompresses them to count only for an unusually
/// high ratio.
void check_claim(const std::string& path, std::uint64_t offset, std::uint64_t bytes);

/// Reads `bytes` bytes from `offset` on, of the file or of a gzip file's decompressed content. Throws LoadError, with a
/// sentence, if there are fewer.
void read_unpacked(const std::string& path, std::uint64_t offset, std::byte* to, std::uint64_t bytes);

/// Decompresses `bytes` bytes of the zlib or gzip streams from byte `offset` on. Throws LoadError, with a sentence, if there
/// are fewer.
void unpack(const std::string& path, std::uint64_t offset, std::byte* to, std::uint64_t bytes);

/// Decompresses a gzip file into a memory file. Throws LoadError, with a sentence, if it is damaged, incomplete, or larger than
/// `most` bytes.
void unpack_whole(const std::string& path, int to, std::uint64_t most);

/// Fills a memory file with the first `start` bytes of `beginning` and the decompressed rest of the file. Throws LoadError,
/// with a half sentence, as above.
void unpack_rest(const std::string& path, const std::string& beginning, int to, std::uint64_t most);

}  // namespace palpa::reader
