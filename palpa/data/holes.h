// Distance of a grid's places from non-finite voxels.
#pragma once

#include <cstdint>
#include <vector>

#include "palpa/data/grid.h"

namespace palpa::detail {

/// Depth from holes within the samples of a grid: at every voxel the length of the shortest path along the axes of the grid to
/// a place where sampling fails, trilinear in between. A voxel's step along an axis counts its distance over √n, n the number
/// of axes (less on sheared grids): so the depth is 0 in every cell that cannot be sampled, never more than the distance to it,
/// and 1-Lipschitz [m/m]. Perpendicular to a flat face it is 1/√3 of the distance, along the diagonal of a cube all of it; an
/// interpolant of the distance itself would be steeper than 1 at every corner.
///
/// Two bytes for each voxel of a grid with holes, nothing for others.
class Holes {
 public:
  Holes() = default;
  /// Reads all values, on all cores.
  /// \param values          interpolated values: voxels, or coefficients of a spline, with all components
  /// \param world_to_steps  [steps/m] inverse of the geometry's affine
  /// \param reach           [voxels] influence of a value to either side: 1 for a trilinear grid, 2 for a cubic spline
  Holes(const GridGeometry& geometry, const Voxels& values, const Mat3& world_to_steps, int reach);

  bool empty() const noexcept { return depths_.empty(); }

  /// Depth in a cell of the grid, by its first voxel and the fraction [1] across it, axis by axis.
  double depth_m(const std::int64_t (&first)[3], const double (&f)[3]) const noexcept;

 private:
  std::vector<std::uint16_t> depths_;  ///< [unit_m_]
  double unit_m_ = 0.0;
  std::int64_t stride_[3]{};  ///< voxels
  std::int64_t step_[3]{};    ///< voxels to the far corner of a cell; 0 along an axis of one voxel
};

}  // namespace palpa::detail
