#include "compression.h"

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"
#include "source.h"

namespace palpa::reader {

namespace {

/// Compression ratio up to which a claimed size is not checked. More: wrong sizes are found late; less: more files, such as
/// masks, are decompressed only for counting.
constexpr std::uint64_t usual_ratio = 16;
constexpr std::uint64_t most_ratio = 1032;  ///< deflate's highest ratio: larger claims are refused at once

struct Unpacked {
  std::uint64_t bytes = 0;
  bool whole = false;  ///< decompressed to the end of a stream, where its checksum is
};

/// Decompresses the streams of a file in sequence up to `enough` bytes, and passes each part on.
Unpacked unpack_parts(const std::string& path, std::uint64_t offset, std::uint64_t enough,
                      const std::function<void(const char* part, std::size_t bytes)>& use = {}, int window_bits = 15 + 32) {
  detail::InputStream file(path);
  file.seekg(static_cast<std::streamoff>(offset));
  z_stream stream{};
  // +32: zlib or gzip, by the header; negative: raw deflate.
  if (inflateInit2(&stream, window_bits) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, inflateEnd);

  std::vector<char> packed(1 << 16), unpacked(1 << 18);
  Unpacked got;
  bool is_new = true;  // this stream has no output yet
  for (int result = Z_OK; got.bytes < enough && (result == Z_OK || result == Z_STREAM_END);) {
    if (stream.avail_in == 0) {
      file.read(packed.data(), static_cast<std::streamsize>(packed.size()));
      stream.avail_in = static_cast<uInt>(file.gcount());
      stream.next_in = reinterpret_cast<Bytef*>(packed.data());
      if (stream.avail_in == 0) break;
    }
    if (result == Z_STREAM_END) inflateReset(&stream), is_new = true;
    stream.next_out = reinterpret_cast<Bytef*>(unpacked.data());
    stream.avail_out = static_cast<uInt>(unpacked.size());
    result = inflate(&stream, Z_NO_FLUSH);
    const std::size_t part = unpacked.size() - stream.avail_out;
    if (use && part > 0) use(unpacked.data(), part);
    got.bytes += part;
    is_new = is_new && part == 0;
    // Bytes behind a complete stream that are no stream, such as zero padding, are ignored.
    const bool is_no_stream = is_new && (result < 0 || stream.total_in < 2);
    got.whole = result == Z_STREAM_END || (got.whole && is_no_stream);
  }
  return got;
}

}  // namespace

void check_compression(const std::string& path, std::uint64_t offset) {
  if (!unpack_parts(path, offset, UINT64_MAX).whole)
    throw LoadError("cannot be read: its compressed data are damaged or not whole; get the file again");
}

void check_claim(const std::string& path, std::uint64_t offset, std::uint64_t bytes) {
  const std::uint64_t packed = file_bytes(path);
  if (bytes / usual_ratio <= packed) return;
  if (bytes / most_ratio > packed || unpack_parts(path, offset, bytes).bytes < bytes)
    throw LoadError("is shorter than its header says; get the whole file, or correct its sizes");
}

void unpack(const std::string& path, std::uint64_t offset, std::byte* to, std::uint64_t bytes) {
  std::uint64_t left = bytes;
  const auto copy = [&](const char* part, std::size_t count) {
    const std::size_t wanted = static_cast<std::size_t>(std::min<std::uint64_t>(count, left));
    std::memcpy(to, part, wanted);
    to += wanted, left -= wanted;
  };
  unpack_parts(path, offset, bytes, copy);
  if (left > 0) throw LoadError("is shorter than its header says; get the whole file");
}

namespace {

/// Writes parts to a memory file. \param by  program that decompresses the file, for errors
class MemoryWriter {
 public:
  MemoryWriter(int to, std::uint64_t most, std::string by) : to_(to), most_(most), by_(std::move(by)) {}
  void operator()(const char* part, std::size_t count) {
    bytes_ += count;
    if (bytes_ > most_) {
      throw LoadError("unpacks to more than the " + protocol::readable_bytes(static_cast<double>(most_)) +
                      " that are allowed; unpack it (" + by_ + "), and crop or downsample what it holds");
    }
    while (count > 0) {
      const ssize_t done = ::write(to_, part, count);
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) throw LoadError("cannot be unpacked in memory; unpack it (" + by_ + ")");
      part += done, count -= static_cast<std::size_t>(done);
    }
  }

 private:
  int to_;
  std::uint64_t most_, bytes_ = 0;
  std::string by_;
};

}  // namespace

void unpack_whole(const std::string& path, int to, std::uint64_t most) {
  if (!unpack_parts(path, 0, UINT64_MAX, MemoryWriter(to, most, "gunzip")).whole)
    throw LoadError("cannot be read: its gzip compression is damaged or not whole; get the file again");
}

void unpack_rest(const std::string& path, const std::string& beginning, int to, std::uint64_t most) {
  const char* const by = "gdcmconv --raw, or dcmconv +te";
  if (to < 0 || ::ftruncate(to, 0) != 0 || ::lseek(to, 0, SEEK_SET) != 0)
    throw LoadError(std::string("is packed as a whole, and there is no memory to unpack it; unpack it (") + by + ")");
  MemoryWriter write(to, most, by);
  write(beginning.data(), beginning.size());
  if (!unpack_parts(path, beginning.size(), UINT64_MAX, std::ref(write), -15).whole)
    throw LoadError("cannot be read: its compression is damaged or not whole; get the file again");
}

void read_unpacked(const std::string& path, std::uint64_t offset, std::byte* to, std::uint64_t bytes) {
  const detail::InputFile opened(path);
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(::gzdopen(::dup(opened.descriptor()), "rb"), ::gzclose);
  bool read = file && ::gzseek(file.get(), static_cast<z_off_t>(offset), SEEK_SET) == static_cast<z_off_t>(offset);
  constexpr std::uint64_t most_at_once = 1 << 30;  // zlib's counts have 32 bits
  for (std::uint64_t done = 0; read && done < bytes;) {
    const int got = ::gzread(file.get(), to + done, static_cast<unsigned>(std::min(bytes - done, most_at_once)));
    read = got > 0;
    done += static_cast<std::uint64_t>(std::max(got, 0));
  }
  if (!read) throw LoadError("is damaged, or shorter than its header says; get the whole file");
}

}  // namespace palpa::reader
