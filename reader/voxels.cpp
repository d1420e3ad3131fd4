#include "voxels.h"

#include <cstring>

namespace palpa::reader {
namespace {

VoxelType turned_type(RawType type) noexcept {
  switch (type) {
    case RawType::int8:
    case RawType::uint8:
    case RawType::int16:
    case RawType::uint16:
    case RawType::float32: return VoxelType::float32;
    default: return VoxelType::float64;
  }
}

/// One voxel after the other, in the order in which they are kept.
template <class Each>
void for_each_voxel(const RawVoxels& raw, Each each) {
  for (std::int64_t k = 0; k < raw.dims[2]; ++k) {
    for (std::int64_t j = 0; j < raw.dims[1]; ++j) {
      std::int64_t at = k * raw.stride[2] + j * raw.stride[1];
      for (std::int64_t i = 0; i < raw.dims[0]; ++i, at += raw.stride[0]) each(at);
    }
  }
}

}  // namespace

VoxelType exact_type(RawType type) noexcept {
  switch (type) {
    case RawType::int8:
    case RawType::int16: return VoxelType::int16;
    case RawType::uint8: return VoxelType::uint8;
    case RawType::uint16: return VoxelType::uint16;
    case RawType::int32: return VoxelType::int32;
    case RawType::float32: return VoxelType::float32;
    default: return VoxelType::float64;
  }
}

std::size_t size_of(RawType type) noexcept {
  std::size_t bytes = 0;
  with_type(type, [&](auto value) { bytes = sizeof value; });
  return bytes;
}

Mat3 unit_axes(const GridGeometry& grid) noexcept {
  Mat3 rows = transposed(grid.index_to_world_m);
  for (Vec3& row : rows.row) row = normalized(row);
  return transposed(rows);
}

void keep(const RawVoxels& raw, Turn& turn, protocol::FieldHeader& field, std::vector<std::string>& warnings) {
  field.components = raw.components;
  field.grid.dims = raw.dims;
  if (raw.components != 3) turn = {};
  if (turn.none()) {
    field.type = exact_type(raw.type);
  } else {
    // A turned offset is no offset common to all components: both are worked into the numbers.
    field.type = turned_type(raw.type);
    turn.scale = field.scale, turn.offset = field.offset;
    field.scale = 1.0, field.offset = 0.0;
  }
  if (raw.type == RawType::int64 || raw.type == RawType::uint64) {
    warnings.push_back("64-bit integers are kept as float64: exact up to 9007199254740992");
  }
}

bool kept_as_they_are(const RawVoxels& raw, const Turn& turn, const protocol::FieldHeader& field) noexcept {
  bool same = false;
  with_type(raw.type,
            [&](auto from) { with_type(field.type, [&](auto to) { same = std::is_same_v<decltype(from), decltype(to)>; }); });
  const std::int64_t c = raw.components;
  return same && turn.none() && (c == 1 || raw.component_stride == 1) && raw.stride[0] == c &&
         raw.stride[1] == c * raw.dims[0] && raw.stride[2] == c * raw.dims[0] * raw.dims[1];
}

void copy_voxels(const void* first, const RawVoxels& raw, const Turn& turn, const protocol::FieldHeader& field, std::byte* to) {
  if (kept_as_they_are(raw, turn, field)) {
    std::memcpy(to, first, *protocol::voxel_bytes(field));
    return;
  }
  with_type(raw.type, [&](auto from_value) {
    using From = decltype(from_value);
    const From* from = static_cast<const From*>(first);
    with_type(field.type, [&](auto to_value) {
      using To = decltype(to_value);
      To* out = reinterpret_cast<To*>(to);
      if (turn.none()) {
        for_each_voxel(raw, [&](std::int64_t at) {
          for (int c = 0; c < raw.components; ++c) *out++ = static_cast<To>(from[at + c * raw.component_stride]);
        });
      } else {
        const auto value = [&](std::int64_t at) { return static_cast<double>(from[at]) * turn.scale + turn.offset; };
        const std::int64_t step = raw.component_stride;
        for_each_voxel(raw, [&](std::int64_t at) {
          const Vec3 v = turn.axes * Vec3{value(at), value(at + step), value(at + 2 * step)};
          *out++ = static_cast<To>(v.x), *out++ = static_cast<To>(v.y), *out++ = static_cast<To>(v.z);
        });
      }
    });
  });
}

}  // namespace palpa::reader
