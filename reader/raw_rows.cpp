#include "raw_rows.h"

#include <algorithm>

#include "palpa/base/load_error.h"
#include "palpa/data/parallel.h"

namespace palpa::reader {

RawRows::RawRows(const std::string& path, std::uint64_t offset, const protocol::RawVoxels& raw, std::int64_t frames)
    : file_(path), offset_(offset), raw_(raw), frames_(frames) {}

bool RawRows::can_read() const noexcept {
  const std::int64_t c = raw_.components;
  const bool in_order = (c == 1 || raw_.component_stride == 1) && raw_.stride[0] == c && raw_.stride[1] == c * raw_.dims[0] &&
                        raw_.stride[2] == c * raw_.dims[0] * raw_.dims[1];
  std::uint64_t end = 0;
  return in_order && file_.is_open() &&
         !__builtin_mul_overflow(static_cast<std::uint64_t>(raw_.stride[2]), static_cast<std::uint64_t>(raw_.dims[2]), &end) &&
         !__builtin_mul_overflow(end, static_cast<std::uint64_t>(frames_), &end) &&
         !__builtin_mul_overflow(end, size_of(raw_.type), &end) && !__builtin_add_overflow(end, offset_, &end) &&
         end <= file_.bytes();
}

void RawRows::read(const protocol::VectorTurn& turn, const protocol::FieldHeader& field, std::int64_t slice, std::int64_t first,
                   std::int64_t count, std::byte* to) const {
  read_voxels(turn, field, (slice * raw_.dims[1] + first) * raw_.dims[0], count * raw_.dims[0], to);
}

void RawRows::read_frames(const protocol::VectorTurn& turn, const protocol::FieldHeader& field,
                          const std::vector<std::byte*>& to,
                          const std::function<void(std::byte*, const std::byte*, std::uint64_t)>& put) const {
  // [bytes] Read before they are put. More: out of the cache in between; less: more calls.
  constexpr std::int64_t at_once_bytes = 1 << 18;
  constexpr std::int64_t most_threads = 8;  // [1] more: their stacks take the address space of a damaged file's limit
  const std::int64_t voxels = raw_.dims[0] * raw_.dims[1] * raw_.dims[2];
  const auto kept = static_cast<std::int64_t>(size_of(field.type)) * raw_.components, at_once = at_once_bytes / kept;
  for (std::size_t frame = 0; frame < to.size(); ++frame) {
    const std::int64_t before = static_cast<std::int64_t>(frame) * voxels;
    detail::in_parts(voxels, std::max(2 * at_once, voxels / most_threads + 1), [&](std::int64_t first, std::int64_t last) {
      std::vector<std::byte> piece(static_cast<std::size_t>(std::min(at_once, last - first) * kept));
      for (std::int64_t v = first; v < last; v += at_once) {
        const std::int64_t count = std::min(at_once, last - v);
        read_voxels(turn, field, before + v, count, piece.data());
        put(to[frame] + v * kept, piece.data(), static_cast<std::uint64_t>(count * kept));
      }
    });
  }
}

/// Voxels in a line, so that a piece may begin and end within a row.
void RawRows::read_voxels(const protocol::VectorTurn& turn, const protocol::FieldHeader& field, std::int64_t first,
                          std::int64_t count, std::byte* to) const {
  protocol::RawVoxels line = raw_;
  line.dims = {count, 1, 1};
  line.stride = {raw_.components, count * raw_.components, count * raw_.components};
  protocol::FieldHeader of = field;
  of.grid.dims = line.dims;
  const std::uint64_t voxel = size_of(raw_.type) * static_cast<std::uint64_t>(raw_.components);
  const std::size_t bytes = static_cast<std::size_t>(count) * voxel;
  const bool direct = kept_as_they_are(line, turn, of);
  std::vector<std::byte> room(direct ? 0 : bytes);
  if (file_.read(offset_ + static_cast<std::uint64_t>(first) * voxel, direct ? to : room.data(), bytes) != bytes)
    throw LoadError("was cut short while it was read; get the whole file");
  if (!direct) copy_voxels(room.data(), line, turn, of, to);
}

}  // namespace palpa::reader
