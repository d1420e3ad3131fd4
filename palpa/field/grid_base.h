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
  /// \param one_row_in    as of grid_field_to_look_at
  GridBase(const GridGeometry& geometry, Voxels voxels, double scale, double offset, Filter filter, bool signless = false,
           std::shared_ptr<const void> coefficients = {}, std::int64_t one_row_in = 1);

  const GridView& view() const noexcept { return view_; }

  int components() const noexcept override { return view_.voxels.components; }
  double spacing_m() const noexcept override { return spacing_m_; }
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
    double per_step = 1.0;   ///< [voxels/step of the affine] indices passed; 1 but between the planes of a rectilinear axis
  };

  /// In steps of the affine: of an axis without planes of its own, voxels.
  Vec3 steps_of(const Vec3& world_m) const noexcept { return world_to_steps_ * (world_m - view_.geometry.origin_m); }

  /// False outside; also for positions that are not finite, because every comparison with NaN fails.
  bool locate(const Vec3& world_m, Cell (&cells)[3]) const noexcept {
    const Vec3 at = steps_of(world_m);
    return enter<0>(at.x, cells[0]) && enter<1>(at.y, cells[1]) && enter<2>(at.z, cells[2]);
  }

  Vec3 gradient_of(const Vec3& d, const Cell (&cells)[3]) const noexcept {
    const Vec3 by_step{d.x * cells[0].per_step, d.y * cells[1].per_step, d.z * cells[2].per_step};
    return transposed_times(world_to_steps_, view_.scale * by_step);
  }

  GridView view_;
  std::shared_ptr<const void> coefficients_;  ///< what is interpolated: the voxels, or coefficients of a spline
  Mat3 world_to_steps_;                       ///< [steps/m]
  std::int64_t stride_[3];                    ///< values from voxel to voxel

 private:
  template <int Axis>
  bool enter(double at, Cell& cell) const noexcept {
    if (!(at >= -beyond_[Axis] && at <= last_[Axis] + beyond_[Axis])) return false;
    const double clamped = std::min(std::max(at, 0.0), last_[Axis]);
    if (const double* planes = planes_[Axis]) {
      cell.first = std::min(plane_before(planes, cells_[Axis], clamped), cells_[Axis] - 1);
      cell.per_step = 1.0 / (planes[cell.first + 1] - planes[cell.first]);
      cell.f = (clamped - planes[cell.first]) * cell.per_step;
      return true;
    }
    cell.first = std::min(static_cast<std::int64_t>(clamped), cells_[Axis] - 1);
    cell.f = clamped - static_cast<double>(cell.first);
    return true;
  }

  /// The last of the planes 0…last that lies at or before a place [steps], which is at 0 or behind it.
  static std::int64_t plane_before(const double* planes, std::int64_t last, double at) noexcept {
    return std::upper_bound(planes + 1, planes + last + 1, at) - planes - 1;
  }

  const double* planes_[3];  ///< [steps] places of the planes of a rectilinear axis; nullptr of another
  double spacing_m_ = 0.0;
  double last_[3];              ///< [steps] of the last voxel, its index too
  double half_[3];              ///< [steps] data beyond the first and last centre
  double beyond_[3];            ///< [steps] the same, with the tolerance
  std::int64_t cells_[3];       ///< cells along each axis, at least one
  double plane_distance_m_[3];  ///< between neighbouring planes of voxels, their mean on a rectilinear axis
  Box bounds_m_;
  struct Way;
  /// Crosses whole bricks from where the way was entered that are quiet, or without data; false where it was entered in
  /// another.
  bool cross_bricks(const Bricks& bricks, const Way& way, const Extent& quiet, Stretch& piece) const noexcept;

  bool is_finite_on(int component, const Passage& cell) const noexcept;

  std::vector<Extent> extents_;
  Bricks bricks_;  ///< of a scalar field whose voxels have all been read
};

}  // namespace palpa::detail
