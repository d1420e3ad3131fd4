#include "palpa/file/protocol_voxels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "palpa/base/load_error.h"

namespace palpa::protocol {
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

/// Element at an index: possibly unaligned, as no library has read it.
template <class T>
T number_at(const void* first, std::int64_t at, bool swapped) noexcept {
  std::array<std::byte, sizeof(T)> bytes;
  std::memcpy(bytes.data(), static_cast<const std::byte*>(first) + at * static_cast<std::int64_t>(sizeof(T)), sizeof(T));
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// Calls `each` voxel by voxel, in the order of the result.
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

void keep(const RawVoxels& raw, VectorTurn& turn, FieldHeader& field, std::vector<std::string>& warnings) {
  field.components = raw.components;
  field.grid.dims = raw.dims;
  if (raw.components != 3) turn = {};
  if (turn.none()) {
    field.type = exact_type(raw.type);
  } else {
    // A rotated offset differs between components: scale and offset are applied to the numbers.
    field.type = turned_type(raw.type);
    turn.scale = field.scale, turn.offset = field.offset;
    field.scale = 1.0, field.offset = 0.0;
  }
  if (raw.type == RawType::int64 || raw.type == RawType::uint64) {
    warnings.push_back("64-bit integers are kept as float64: exact up to 9007199254740992");
  }
}

RawType type_named(std::string_view name) {
  static constexpr std::pair<std::string_view, RawType> names[] = {
      {"int8", RawType::int8},       {"uint8", RawType::uint8},    {"int16", RawType::int16}, {"uint16", RawType::uint16},
      {"int32", RawType::int32},     {"uint32", RawType::uint32},  {"int64", RawType::int64}, {"uint64", RawType::uint64},
      {"float32", RawType::float32}, {"float64", RawType::float64}};
  for (const auto& [known, type] : names) {
    if (known == name) return type;
  }
  throw LoadError("is asked for with type = \"" + std::string(name) +
                  "\"; int8 to int64, uint8 to uint64, float32 and float64 are known");
}

std::string axes_of(const ArrayLayout& layout) {
  const std::string axes = layout.axes.empty() ? "zyx" : layout.axes;
  std::string sorted = axes;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != "xyz")
    throw LoadError("is asked for with axes = \"" + axes + "\"; give x, y and z in the order of the indices, slowest first");
  return axes;
}

RawVoxels arranged(RawType type, const std::vector<std::int64_t>& lengths, const ArrayLayout& layout) {
  const std::size_t rank = lengths.size();
  if (rank != 3 && rank != 4)
    throw LoadError("has " + std::to_string(rank) + " indices; a volume has 3, or 4 with vector components");
  std::vector<std::int64_t> strides(rank, 1);
  for (std::size_t n = rank - 1; n > 0; --n) {
    if (__builtin_mul_overflow(strides[n], lengths[n], &strides[n - 1]))
      throw LoadError("has more voxels than can be counted; give one that holds a volume");
  }
  RawVoxels raw;
  raw.type = type;
  std::size_t first_of_space = 0;
  if (rank == 4) {
    const bool last = layout.components.empty() ? lengths[3] == 3 : layout.components == "last";
    if (layout.components.empty() && last == (lengths[0] == 3)) {
      throw LoadError(
          "has four indices, and which is that of the components is not clear; say components = \"first\" or \"last\"");
    }
    const std::size_t at = last ? 3 : 0;
    if (lengths[at] != 3) throw LoadError("has " + std::to_string(lengths[at]) + " components; a vector has 3");
    raw.components = 3, raw.component_stride = strides[at];
    first_of_space = last ? 0 : 1;
  }
  const std::string axes = axes_of(layout);
  for (std::size_t n = 0; n < 3; ++n) {
    const auto a = static_cast<std::size_t>(axes[n] - 'x');
    raw.dims[a] = lengths[first_of_space + n], raw.stride[a] = strides[first_of_space + n];
    if (layout.dims[a] != 0 && layout.dims[a] != raw.dims[a]) {
      throw LoadError("has " + std::to_string(raw.dims[a]) + " voxels along " + axes[n] + ", where dims says " +
                      std::to_string(layout.dims[a]) + "; correct dims or axes");
    }
  }
  return raw;
}

GridGeometry placed_by(const ArrayLayout& layout, Header& header) {
  Vec3 step = layout.spacing_m;
  if (step == Vec3{}) {
    step = {1, 1, 1};
    header.warnings.push_back("says no distances of voxels: 1 is taken (spacing_m = [x, y, z] takes others)");
  } else {
    header.length_unit = "m";
  }
  GridGeometry grid;
  grid.index_to_world_m = {{{step.x, 0, 0}, {0, step.y, 0}, {0, 0, step.z}}};
  grid.origin_m = layout.origin_m.value_or(Vec3{});
  return grid;
}

bool kept_as_they_are(const RawVoxels& raw, const VectorTurn& turn, const FieldHeader& field) noexcept {
  bool same = false;
  with_type(raw.type,
            [&](auto from) { with_type(field.type, [&](auto to) { same = std::is_same_v<decltype(from), decltype(to)>; }); });
  const std::int64_t c = raw.components;
  return same && turn.none() && (!raw.swapped || size_of(raw.type) == 1) && (c == 1 || raw.component_stride == 1) &&
         raw.stride[0] == c && raw.stride[1] == c * raw.dims[0] && raw.stride[2] == c * raw.dims[0] * raw.dims[1];
}

void copy_voxels(const void* first, const RawVoxels& raw, const VectorTurn& turn, const FieldHeader& field, std::byte* to) {
  if (kept_as_they_are(raw, turn, field)) {
    std::memcpy(to, first, *voxel_bytes(field));
    return;
  }
  with_type(raw.type, [&](auto from_value) {
    using From = decltype(from_value);
    const auto number = [&](std::int64_t at) { return number_at<From>(first, at, raw.swapped); };
    with_type(field.type, [&](auto to_value) {
      using To = decltype(to_value);
      To* out = reinterpret_cast<To*>(to);
      if (turn.none()) {
        for_each_voxel(raw, [&](std::int64_t at) {
          for (int c = 0; c < raw.components; ++c) *out++ = static_cast<To>(number(at + c * raw.component_stride));
        });
      } else {
        const auto value = [&](std::int64_t at) { return static_cast<double>(number(at)) * turn.scale + turn.offset; };
        const std::int64_t step = raw.component_stride;
        for_each_voxel(raw, [&](std::int64_t at) {
          const Vec3 v = turn.axes * Vec3{value(at), value(at + step), value(at + 2 * step)};
          *out++ = static_cast<To>(v.x), *out++ = static_cast<To>(v.y), *out++ = static_cast<To>(v.z);
        });
      }
    });
  });
}

}  // namespace palpa::protocol
