#include "palpa/file/gzip_writer.h"

#include <zlib.h>

#include <algorithm>
#include <vector>

#include "palpa/base/load_error.h"

namespace palpa::detail {

namespace {
// [bytes] At once, of input and of output. More: memory; less: calls.
constexpr std::size_t piece = std::size_t{1} << 18;
}  // namespace

struct GzipWriter::State {
  z_stream stream{};
  std::vector<Bytef> packed = std::vector<Bytef>(piece);
};

GzipWriter::GzipWriter(NewFile& to) : to_(to), state_(std::make_unique<State>()) {
  constexpr int gzip_header = 16 + MAX_WBITS, most_memory = 9;
  if (deflateInit2(&state_->stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, gzip_header, most_memory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw LoadError("cannot be packed: no memory is left; close other programs");
}

GzipWriter::~GzipWriter() { deflateEnd(&state_->stream); }

void GzipWriter::write(const void* data, std::size_t bytes) {
  const auto* next = static_cast<const Bytef*>(data);
  while (bytes > 0) {
    const std::size_t now = std::min(bytes, piece);
    state_->stream.next_in = const_cast<Bytef*>(next);
    state_->stream.avail_in = static_cast<uInt>(now);
    put(Z_NO_FLUSH);
    next += now, bytes -= now;
  }
}

void GzipWriter::finish() { put(Z_FINISH); }

void GzipWriter::put(int flush) {
  do {
    state_->stream.next_out = state_->packed.data();
    state_->stream.avail_out = static_cast<uInt>(piece);
    deflate(&state_->stream, flush);
    to_.write(state_->packed.data(), piece - state_->stream.avail_out);
  } while (state_->stream.avail_out == 0);
}

}  // namespace palpa::detail
