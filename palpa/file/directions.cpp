#include "palpa/file/directions.h"

#include <cmath>

#include "palpa/data/grid.h"
#include "palpa/data/statistics.h"
#include "palpa/data/volume.h"

namespace palpa {
namespace {

/// Agreement of directions with the voxels three further along them: the mean of |cos|.
double agreement(const Field& directions) {
  constexpr double way = 3.0;        // [voxels] distance along a direction to the compared one
  constexpr std::int64_t rows = 40;  // about as many places along each axis. More: slower; fewer: a less certain mean
  const GridGeometry& grid = grid_of(directions)->geometry;
  const Mat3 to_index = inverse(grid.index_to_world_m);
  const auto step = [&](std::size_t a) { return 1 + grid.dims[a] / rows; };
  const auto at_voxel = [&](double i, double j, double k) { return directions.vector(grid.to_world({i, j, k})).value; };
  double sum = 0.0, looked_at = 0.0;
  for (std::int64_t k = 0; k < grid.dims[2]; k += step(2))
    for (std::int64_t j = 0; j < grid.dims[1]; j += step(1))
      for (std::int64_t i = 0; i < grid.dims[0]; i += step(0)) {
        const Vec3 at{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
        const Vec3 here = at_voxel(at.x, at.y, at.z);
        // At voxels only: signs of neighbours may differ, so that their blend is meaningless.
        const Vec3 to = at + way * directions.spacing_m() * (to_index * here);
        const Vec3 there = at_voxel(std::round(to.x), std::round(to.y), std::round(to.z));
        if (here == Vec3{} || there == Vec3{}) continue;
        sum += std::abs(dot(here, there)), looked_at += 1.0;
      }
  return looked_at > 0.0 ? sum / looked_at : 0.0;
}

}  // namespace

std::optional<VolumeRequest> as_directions(const VolumeRequest& request, const VolumeFile& file, const ReadOptions& options) {
  if (file.frames != 3 || !request.as.empty() || file.volume.fields.size() != 1) return std::nullopt;
  const GridView* grid = grid_of(*file.volume.fields.front().field);
  if (!grid || (grid->voxels.type != VoxelType::float32 && grid->voxels.type != VoxelType::float64)) return std::nullopt;
  VolumeRequest asked = request;
  asked.as = "vector";
  try {
    const Volume as_said = read_volume(asked, options);
    const Field& directions = *as_said.fields.front().field;
    if (!looks_like_directions(statistics(directions))) return std::nullopt;
    if (!request.components_along.empty()) return asked;
    VolumeRequest along_grid = asked;
    along_grid.components_along = "index";
    const Volume turned = read_volume(along_grid, options);
    return agreement(*turned.fields.front().field) > agreement(directions) ? along_grid : asked;
  } catch (const LoadError&) {
    return std::nullopt;  // a format without vectors of frames
  }
}

}  // namespace palpa
