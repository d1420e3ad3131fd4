// What grids have in common, whatever lies between their voxels: place, extent, range.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "palpa/field/bricks.h"
#include "palpa/field/grid.h"

namespace palpa::detail {

/// Positions this far [voxels] beyond the first or last voxel centre count as on it: rounding of world
/// coordinates must not put a corner of the grid outside.
inline constexpr double face_tolerance_voxels = 1e-6;

/// Throws std::invalid_argument, with a sentence, where a grid cannot be made of these (see grid_field). Scale and offset
/// in the field's own unit.
void check_grid(const GridGeometry& geometry, const Voxels& voxels, double scale, double offset);

/// Inverse [voxels/m] of the steps [m] of a usable grid, by way of a matrix near 1, so that steps of any length neither
/// overflow nor lose bits: scaling by a power of two scales the inverse by its reciprocal, exactly.
Mat3 scaled_inverse(const Mat3& steps_m) noexcept;

/// `samples` planes along the longest side of the box, both ends of every side among them; fewer along the others.
/// Throws std::invalid_argument on a box without size.
GridGeometry geometry_over(const Box& box, int samples);

/// The position [m] itself, or the nearest one of the box: rounding must not put the last sample outside.
inline Vec3 within(const Box& box, const Vec3& x) noexcept {
  return {std::clamp(x.x, box.low_m.x, box.high_m.x), std::clamp(x.y, box.low_m.y, box.high_m.y),
          std::clamp(x.z, box.low_m.z, box.high_m.z)};
}

/// Calls `act` with the voxels as an array of their own type.
template <class Act>
auto with_values_of(const Voxels& voxels, Act&& act) {
  const void* data = voxels.data.get();
  switch (voxels.type) {
    case VoxelType::uint8: return act(static_cast<const std::uint8_t*>(data));
    case VoxelType::int16: return act(static_cast<const std::int16_t*>(data));
    case VoxelType::uint16: return act(static_cast<const std::uint16_t*>(data));
    case VoxelType::int32: return act(static_cast<const std::int32_t*>(data));
    case VoxelType::float32: return act(static_cast<const float*>(data));
    case VoxelType::float64: return act(static_cast<const double*>(data));
  }
  throw std::invalid_argument("the grid's type of voxel is unknown");
}

/// All of a grid but the sampling. Reads the voxels for their range and, of a scalar field, that of its bricks.
class GridBase : public Field {
 public:
  /// \param coefficients  of a spline that meets the voxels, as many and of their type; empty: the voxels are what is
  ///                      interpolated
  GridBase(const GridGeometry& geometry, Voxels voxels, double scale, double offset, Filter filter, bool signless = false,
           std::shared_ptr<const void> coefficients = {});

  const GridView& view() const noexcept { return view_; }

  int components() const noexcept override { return view_.voxels.components; }
  double spacing_m() const noexcept override { return *std::min_element(plane_distance_m_, plane_distance_m_ + 3); }
  Box bounds_m() const noexcept override { return bounds_m_; }
  double depth_m(const Vec3& world_m) const noexcept override;
  void prefetch(const Vec3& world_m) const noexcept override;
  std::vector<Extent> extents() const override { return extents_; }

  /// Of a vector field: where there are data, without values (degree −1).
  Stretch stretch(const Vec3& from_m, const Vec3& to_m, double begin, const Extent& quiet) const noexcept override;
  /// The same of one component, with its bricks; without them, cell by cell.
  Stretch stretch_of(int component, const Bricks* bricks, const Vec3& from_m, const Vec3& to_m, double begin,
                     const Extent& quiet) const noexcept;
  Bricks bricks_of(int component) const {
    const int reach = view_.filter == Filter::trilinear ? 0 : 1;
    return {view_.geometry, {view_.voxels.type, view_.voxels.components, coefficients_}, component, reach};
  }

 protected:
  /// A straight piece across one cell: its first voxel, and where in the cell the piece begins and ends.
  struct Passage {
    std::int64_t first[3];  ///< [voxels]
    double begin[3];        ///< [1] 0…1 across the cell
    double end[3];          ///< [1] 0…1 across the cell
  };
  /// Degree and control of the piece, raw; degree −1 where the raw hull of the cell is quiet. Not finite where a voxel is not.
  virtual void polynomial(int component, const Passage& cell, const Extent& quiet, Stretch& piece) const noexcept = 0;

  /// Values between these raw ones stay in the interval: on the side of its levels where they are.
  bool is_quiet(double raw_min, double raw_max, const Extent& quiet) const noexcept {
    const double one = raw_min * view_.scale + view_.offset, other = raw_max * view_.scale + view_.offset;
    return std::min(one, other) >= quiet.min && std::max(one, other) < quiet.max;
  }

  /// The cell of a position along one axis: its first voxel, the fraction [1] across it.
  struct Cell {
    std::int64_t first = 0;  ///< [voxels]
    double f = 0.0;          ///< [1] 0…1
  };

  Vec3 index_of(const Vec3& world_m) const noexcept { return world_to_index_ * (world_m - view_.geometry.origin_m); }

  /// False outside; also for positions that are not finite, because every comparison with NaN fails.
  bool locate(const Vec3& world_m, Cell (&cells)[3]) const noexcept {
    const Vec3 index = index_of(world_m);
    return enter<0>(index.x, cells[0]) && enter<1>(index.y, cells[1]) && enter<2>(index.z, cells[2]);
  }

  Vec3 gradient_of(const Vec3& index_derivative) const noexcept {
    return transposed_times(world_to_index_, view_.scale * index_derivative);
  }

  GridView view_;
  std::shared_ptr<const void> coefficients_;  ///< what is interpolated: the voxels, or coefficients of a spline
  Mat3 world_to_index_;                       ///< [voxels/m]
  std::int64_t stride_[3];                    ///< values from voxel to voxel

 private:
  template <int Axis>
  bool enter(double index, Cell& cell) const noexcept {
    if (!(index >= -beyond_[Axis] && index <= last_[Axis] + beyond_[Axis])) return false;
    const double clamped = std::min(std::max(index, 0.0), last_[Axis]);
    cell.first = std::min(static_cast<std::int64_t>(clamped), cells_[Axis] - 1);
    cell.f = clamped - static_cast<double>(cell.first);
    return true;
  }

  double last_[3];              ///< index of the last voxel
  double half_[3];              ///< [voxels] data beyond the first and last centre
  double beyond_[3];            ///< [voxels] the same, with the tolerance
  std::int64_t cells_[3];       ///< cells along each axis, at least one
  double plane_distance_m_[3];  ///< between neighbouring planes of voxels
  Box bounds_m_;
  struct Way;
  /// Crosses whole bricks from where the way was entered that are quiet, or without data; false where it was entered in
  /// another.
  bool cross_bricks(const Bricks& bricks, const Way& way, const Extent& quiet, Stretch& piece) const noexcept;

  bool is_finite_on(int component, const Passage& cell) const noexcept;

  std::vector<Extent> extents_;
  Bricks bricks_;  ///< of a scalar field
};

}  // namespace palpa::detail
