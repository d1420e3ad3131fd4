#include "palpa/file/sliced_file.h"

#include <algorithm>
#include <cstring>

#include "palpa/base/load_error.h"
#include "palpa/file/store_reader.h"
#include "palpa/file/unit_walk.h"

namespace palpa {

SlicedFile::SlicedFile(std::unique_ptr<StoreReader> reader, std::vector<std::uint32_t> arrays)
    : reader_(std::move(reader)), arrays_(std::move(arrays)) {}
SlicedFile::~SlicedFile() = default;

std::int64_t SlicedFile::rows_at_once() const noexcept { return reader_->contents().octaves.front().chunk[1]; }

void SlicedFile::read(std::size_t field, const SliceRows& range, std::byte* to) {
  const Field& of = fields[field];
  const std::int64_t each = rows_at_once(), end = range.first_row + range.rows;
  const std::size_t row_bytes =
      static_cast<std::size_t>(of.grid.dims[0]) * static_cast<std::size_t>(of.components) * size_of(of.type);
  std::vector<StoreChunk> order;
  for (std::int64_t k = range.first_slice; k < range.first_slice + range.slices; ++k)
    for (std::int64_t j = range.first_row / each; j * each < end; ++j)
      order.push_back({.field = static_cast<std::int32_t>(arrays_[field]), .at = {0, j, k}});
  detail::ChunkStream chunks(*reader_, [] { return true; });
  chunks.follow(order);
  for (const StoreChunk& chunk : order) {
    const std::int64_t low = chunk.at[1] * each, first = std::max(low, range.first_row), last = std::min(low + each, end);
    const std::int64_t row = (chunk.at[2] - range.first_slice) * range.rows + first - range.first_row;
    chunks.take([&](const StoreRead&, std::span<const std::byte> content) {
      if (content.size() < static_cast<std::size_t>(last - low) * row_bytes)
        throw LoadError("cannot be read: palpa-read gave no rows; update both programs together");
      std::memcpy(to + static_cast<std::size_t>(row) * row_bytes,
                  content.data() + static_cast<std::size_t>(first - low) * row_bytes,
                  static_cast<std::size_t>(last - first) * row_bytes);
    });
  }
}

}  // namespace palpa
