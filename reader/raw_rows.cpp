#include "raw_rows.h"

#include "palpa/base/load_error.h"

namespace palpa::reader {

RawRows::RawRows(const std::string& path, std::uint64_t offset, const protocol::RawVoxels& raw)
    : file_(path), offset_(offset), raw_(raw) {}

bool RawRows::can_read() const noexcept {
  const std::int64_t c = raw_.components;
  const bool in_order = (c == 1 || raw_.component_stride == 1) && raw_.stride[0] == c && raw_.stride[1] == c * raw_.dims[0] &&
                        raw_.stride[2] == c * raw_.dims[0] * raw_.dims[1];
  std::uint64_t end = 0;
  return in_order && file_.is_open() &&
         !__builtin_mul_overflow(static_cast<std::uint64_t>(raw_.stride[2]), static_cast<std::uint64_t>(raw_.dims[2]), &end) &&
         !__builtin_mul_overflow(end, size_of(raw_.type), &end) && !__builtin_add_overflow(end, offset_, &end) &&
         end <= file_.bytes();
}

void RawRows::read(const protocol::VectorTurn& turn, const protocol::FieldHeader& field, std::int64_t slice, std::int64_t first,
                   std::int64_t count, std::byte* to) {
  protocol::RawVoxels rows = raw_;
  rows.dims = {raw_.dims[0], count, 1};
  protocol::FieldHeader of = field;
  of.grid.dims = rows.dims;
  const std::size_t number = size_of(raw_.type), bytes = static_cast<std::size_t>(raw_.stride[1] * count) * number;
  const auto from = static_cast<std::uint64_t>(slice * raw_.stride[2] + first * raw_.stride[1]) * number;
  const bool direct = kept_as_they_are(rows, turn, of);
  room_.resize(direct ? 0 : bytes);
  if (file_.read(offset_ + from, direct ? to : room_.data(), bytes) != bytes)
    throw LoadError("was cut short while it was read; get the whole file");
  if (!direct) copy_voxels(room_.data(), rows, turn, of, to);
}

}  // namespace palpa::reader
