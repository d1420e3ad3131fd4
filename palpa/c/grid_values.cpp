#include "palpa/c/grid_values.h"

#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "palpa/c/failure.h"
#include "palpa/data/unread_grid.h"

namespace palpa::c {
namespace {

constexpr std::array types = {VoxelType::uint8, VoxelType::int16,   VoxelType::uint16,
                              VoxelType::int32, VoxelType::float32, VoxelType::float64};

Vec3 vector_of(const double (&xyz)[3]) noexcept { return {xyz[0], xyz[1], xyz[2]}; }

/// Bytes of the voxels that a grid names; throws WrongArgument.
std::size_t bytes_of(const palpa_grid& grid, VoxelType type) {
  std::size_t bytes = size_of(type) * static_cast<std::size_t>(grid.components);
  for (const std::int64_t n : grid.dims) {
    if (n < 1) throw WrongArgument("dims has " + std::to_string(n) + "; each is at least 1");
    if (__builtin_mul_overflow(bytes, n, &bytes))
      throw WrongArgument("dims are more than memory can hold; give those of the voxels");
  }
  return bytes;
}

}  // namespace

GridGeometry geometry_of(const palpa_grid& grid) {
  const auto& [i, j, k] = grid.axes_m;
  GridGeometry geometry;
  geometry.dims = {grid.dims[0], grid.dims[1], grid.dims[2]};
  geometry.index_to_world_m = transposed({{vector_of(i), vector_of(j), vector_of(k)}});
  geometry.origin_m = vector_of(grid.origin_m);
  if (const char* problem = problem_with(geometry))
    throw WrongArgument(std::string(problem) + "; see origin_m, axes_m and dims");
  return geometry;
}

Voxels voxels_of(const palpa_grid& grid) {
  if (grid.medical_frame != 0 && grid.medical_frame != 1)
    throw WrongArgument("medical_frame is " + std::to_string(grid.medical_frame) + "; it is 0 or 1");
  if (!std::isfinite(grid.slope) || grid.slope == 0.0) throw WrongArgument("slope is 0 or not finite; 1 keeps the numbers");
  if (!std::isfinite(grid.intercept)) throw WrongArgument("intercept is not finite; 0 keeps the numbers");
  if (grid.type < 0 || static_cast<std::size_t>(grid.type) >= types.size())
    throw WrongArgument("type is " + std::to_string(grid.type) + "; it is one of PALPA_UINT8 to PALPA_FLOAT64");
  if (grid.components != 1 && grid.components != 3)
    throw WrongArgument("components is " + std::to_string(grid.components) + "; it is 1 for scalars or 3 for vectors");
  const VoxelType type = types[static_cast<std::size_t>(grid.type)];
  const std::size_t bytes = bytes_of(grid, type);
  if (!grid.voxels) throw WrongArgument("voxels is NULL; give the first voxel's place");
  if (grid.bytes != bytes)
    throw WrongArgument("bytes is " + std::to_string(grid.bytes) + "; type, components and dims take " + std::to_string(bytes));
  const std::shared_ptr<std::byte[]> copy(new std::byte[bytes]);
  std::memcpy(copy.get(), grid.voxels, bytes);
  return {.type = type, .components = grid.components, .data = copy};
}

Volume volume_of(const palpa_grid& grid) {
  Volume volume;
  volume.format = "grid";
  volume.fields.push_back(
      {.name = "data", .unit = "", .field = unread_grid_field(geometry_of(grid), voxels_of(grid), grid.slope, grid.intercept)});
  volume.medical_frame = grid.medical_frame == 1;
  return volume;
}

}  // namespace palpa::c
