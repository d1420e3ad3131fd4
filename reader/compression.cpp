#include "compression.h"

#include <zlib.h>

#include <fstream>
#include <memory>
#include <vector>

#include "palpa/core/load_error.h"

namespace palpa::reader {

void check_compression(const std::string& path, std::uint64_t offset) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(offset));
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK) throw std::bad_alloc();  // 32: zlib or gzip, as it is
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, inflateEnd);

  std::vector<char> packed(1 << 16), unpacked(1 << 18);
  int result = Z_OK;
  while (result == Z_OK) {
    if (stream.avail_in == 0) {
      file.read(packed.data(), static_cast<std::streamsize>(packed.size()));
      stream.avail_in = static_cast<uInt>(file.gcount());
      stream.next_in = reinterpret_cast<Bytef*>(packed.data());
      if (stream.avail_in == 0) break;
    }
    stream.next_out = reinterpret_cast<Bytef*>(unpacked.data());
    stream.avail_out = static_cast<uInt>(unpacked.size());
    result = inflate(&stream, Z_NO_FLUSH);
  }
  if (result != Z_STREAM_END)
    throw LoadError("cannot be read: its compressed data are damaged or not whole; get the file again");
}

}  // namespace palpa::reader
