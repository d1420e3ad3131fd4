// How far a place of a grid is from voxels that are not finite.
#pragma once

#include <cstdint>
#include <vector>

#include "palpa/data/grid.h"

namespace palpa::detail {

/// The depth within what a grid can be sampled at, holes only: at every voxel the length of the shortest way along the axes of
/// the grid to a place where sampling fails, trilinear in between. A way of one voxel along an axis counts for its distance
/// over √n, where n is the number of axes (and for less on sheared grids): so the depth is 0 throughout every cell
/// that cannot be sampled, never more than the distance to one, and changes by at most its way [m/m]. Straight away from
/// a flat face it is 1/√3 of the distance, along the diagonal of a cube all of it; an interpolant of the distance itself
/// would be steeper than 1 at every corner.
///
/// Two bytes for each voxel of a grid that has holes, nothing for others.
class Holes {
 public:
  Holes() = default;
  /// Reads all values, by as many threads as there are cores.
  /// \param values          what is interpolated: voxels, or coefficients of a spline, with all components
  /// \param world_to_steps  [steps/m] inverse of the geometry's affine
  /// \param reach           [voxels] that a value has a say to either side: 1 of a trilinear grid, 2 of a cubic spline
  Holes(const GridGeometry& geometry, const Voxels& values, const Mat3& world_to_steps, int reach);

  bool empty() const noexcept { return depths_.empty(); }

  /// At a place within the grid, by the first voxel of its cell and the fraction [1] across it, axis by axis.
  double depth_m(const std::int64_t (&first)[3], const double (&f)[3]) const noexcept;

 private:
  std::vector<std::uint16_t> depths_;  ///< [unit_m_]
  double unit_m_ = 0.0;
  std::int64_t stride_[3]{};  ///< voxels
  std::int64_t step_[3]{};    ///< voxels to the far corner of a cell; 0 along an axis of one voxel
};

}  // namespace palpa::detail
