#include "compression.h"

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "palpa/core/load_error.h"
#include "palpa/disk/input_file.h"
#include "source.h"

namespace palpa::reader {

namespace {

/// Ratio of voxels to compressed bytes up to which a claim is believed. More: wrong sizes are found late; less: more files are
/// unpacked only to count their bytes, as masks are.
constexpr std::uint64_t usual_ratio = 16;
constexpr std::uint64_t most_ratio = 1032;  ///< the most that deflate can reach: beyond, a claim is refused at once

struct Unpacked {
  std::uint64_t bytes = 0;
  bool whole = false;  ///< unpacked to the end of a stream, where its checksum lies
};

/// Unpacks the streams of a file, one after the other, until there are `enough` bytes, and keeps nothing.
Unpacked unpack(const std::string& path, std::uint64_t offset, std::uint64_t enough) {
  detail::InputStream file(path);
  file.seekg(static_cast<std::streamoff>(offset));
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK) throw std::bad_alloc();  // 32: zlib or gzip, told by the header
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, inflateEnd);

  std::vector<char> packed(1 << 16), unpacked(1 << 18);
  Unpacked got;
  for (int result = Z_OK; got.bytes < enough && (result == Z_OK || result == Z_STREAM_END);) {
    if (stream.avail_in == 0) {
      file.read(packed.data(), static_cast<std::streamsize>(packed.size()));
      stream.avail_in = static_cast<uInt>(file.gcount());
      stream.next_in = reinterpret_cast<Bytef*>(packed.data());
      if (stream.avail_in == 0) break;
    }
    if (result == Z_STREAM_END) inflateReset(&stream);
    stream.next_out = reinterpret_cast<Bytef*>(unpacked.data());
    stream.avail_out = static_cast<uInt>(unpacked.size());
    result = inflate(&stream, Z_NO_FLUSH);
    got.bytes += unpacked.size() - stream.avail_out;
    got.whole = got.whole || result == Z_STREAM_END;
  }
  return got;
}

}  // namespace

void check_compression(const std::string& path, std::uint64_t offset) {
  if (!unpack(path, offset, UINT64_MAX).whole)
    throw LoadError("cannot be read: its compressed data are damaged or not whole; get the file again");
}

void check_claim(const std::string& path, std::uint64_t offset, std::uint64_t bytes) {
  const std::uint64_t packed = file_bytes(path);
  if (bytes / usual_ratio <= packed) return;
  if (bytes / most_ratio > packed || unpack(path, offset, bytes).bytes < bytes)
    throw LoadError("is shorter than its header says; get the whole file, or correct its sizes");
}

void read_unpacked(const std::string& path, std::uint64_t offset, std::byte* to, std::uint64_t bytes) {
  const detail::InputFile opened(path);
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(::gzdopen(::dup(opened.descriptor()), "rb"), ::gzclose);
  bool read = file && ::gzseek(file.get(), static_cast<z_off_t>(offset), SEEK_SET) == static_cast<z_off_t>(offset);
  constexpr std::uint64_t most_at_once = 1 << 30;  // a number of zlib's has 32 bits
  for (std::uint64_t done = 0; read && done < bytes;) {
    const int got = ::gzread(file.get(), to + done, static_cast<unsigned>(std::min(bytes - done, most_at_once)));
    read = got > 0;
    done += static_cast<std::uint64_t>(std::max(got, 0));
  }
  if (!read) throw LoadError("is damaged, or shorter than its header says; get the whole file");
}

}  // namespace palpa::reader
