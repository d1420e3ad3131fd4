// Common base of grids for any interpolation: position, extent, range.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "palpa/data/bricks.h"
#include "palpa/data/grid.h"
#include "palpa/data/grid_window.h"
#include "palpa/data/holes.h"
#include "palpa/data/spline.h"

namespace palpa::detail {

/// [voxels] Positions up to this far beyond the first or last voxel centre count as on it. Less: rounding of world coordinates
/// puts corners of the grid outside; more: data reach visibly beyond their voxels.
inline constexpr double face_tolerance_voxels = 1e-6;

/// Throws std::invalid_argument, with a sentence, on invalid arguments of a grid (see grid_field). Scale and offset in the
/// field's own unit.
void check_grid(const GridGeometry& geometry, const Voxels& voxels, double scale, double offset);

/// Inverse [voxels/m] of the steps [m] of a valid grid, through a matrix near 1, so that steps of any length neither overflow
/// nor lose bits: scaling by a power of two scales the inverse by its reciprocal, exactly.
Mat3 scaled_inverse(const Mat3& steps_m) noexcept;

/// Grid of `samples` planes along the longest side of the box, both ends of every side included; fewer along the others. Throws
/// std::invalid_argument on an empty box.
GridGeometry geometry_over(const Box& box, int samples);

/// `window_field` of each filter.
FieldPtr trilinear_window(const GridGeometry& whole, const GridWindow& window, Voxels voxels, double scale, double offset);
FieldPtr smooth_window(const GridGeometry& whole, const GridWindow& window, Voxels voxels, double scale, double offset);

/// Position [m] clamped to the box: rounding must not put the last sample outside.
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

/// Results of reading all voxels of a grid.
struct VoxelFacts {
  std::array<std::int64_t, 3> dims;  ///< of that grid
  std::array<ValueRange, 3> ranges;  ///< raw, of each component; min > max if none is finite
  double valid_share = 0.0;          ///< [1] of the voxels with all components finite
  Bricks bricks;
};

/// Grid without its sampling. Reads the voxels for their range and that of its bricks, unless known.
class GridBase : public Field {
 public:
  /// \param coefficients  of a spline through the voxels, as many and of their type; empty: the voxels are interpolated
  /// \param one_row_in    0: for feeling, all rows are read, and bricks made; else as of preview_grid_field
  /// \param window        part of the grid that `voxels` are; nullptr: all of it
  GridBase(const GridGeometry& geometry, Voxels voxels, double scale, double offset, Filter filter, bool signless = false,
           std::shared_ptr<const void> coefficients = {}, std::int64_t one_row_in = 0, const GridWindow* window = nullptr);

  const GridView& view() const noexcept { return view_; }

  /// Part [steps] of the grid with samples: between `low` and `high` along each axis.
  struct Extent {
    double low[3], high[3];
  };
  const Extent& extent() const noexcept { return extent_; }
  Vec3 steps_of(const Vec3& world_m) const noexcept { return world_to_steps_ * (world_m - view_.geometry.origin_m); }
  double plane_distance_m(int axis) const noexcept { return plane_distance_m_[axis]; }
  /// Least way [voxels] from a position to a face of a window behind which the grid goes on; infinite if there is none,
  /// negative beyond one.
  double room_voxels(const Vec3& world_m) const noexcept;
  /// Time [s] after which a position that moves at this velocity [m/s] is nearer than `margin` [voxels] to such a face;
  /// infinite if it never is, 0 if it is now.
  double stays_s(const Vec3& world_m, const Vec3& velocity_m_per_s, double margin) const noexcept;
  /// Shares [1] of the segment between two positions [m] where it enters and leaves the space within such faces; the second is
  /// negative if it is nowhere there.
  std::array<double, 2> passage(const Vec3& from_m, const Vec3& to_m) const noexcept;

  /// Cell of a position along an axis: its first voxel, the fraction [1] across it.
  struct Cell {
    std::int64_t first = 0;  ///< [voxels]
    double f = 0.0;          ///< [1] 0…1
    double per_step = 1.0;  ///< [voxels/step of the affine] indices per step; 1 except between the planes of a rectilinear axis
  };

  /// Place of a grid, valid for all grids of an equal geometry and window.
  struct Place {
    Vec3 world_m;
    Vec3 steps;           ///< [steps] of the affine; voxels along an axis without planes
    bool inside = false;  ///< also false for non-finite positions
    Cell cells[3];
    std::optional<SplineStencil> stencil{};  ///< after the first sample of a spline

    /// \param in_memory  [voxels] along each axis: `dims`, or those of a window
    const SplineStencil& stencil_of(const std::array<std::int64_t, 3>& dims,
                                    const std::array<std::int64_t, 3>& in_memory) noexcept {
      if (!stencil) {
        const std::int64_t first[3] = {cells[0].first, cells[1].first, cells[2].first};
        const double f[3] = {cells[0].f, cells[1].f, cells[2].f};
        stencil.emplace(dims, in_memory, first, f);
      }
      return *stencil;
    }
  };
  void locate(const Vec3& world_m, Place& place) const noexcept {
    place.world_m = world_m;
    place.steps = steps_of(world_m);
    place.inside = enter<0>(place.steps.x, place.cells[0]) && enter<1>(place.steps.y, place.cells[1]) &&
                   enter<2>(place.steps.z, place.cells[2]);
    place.stencil.reset();
  }
  Place place_of(const Vec3& world_m) const noexcept {
    Place place;
    locate(world_m, place);
    return place;
  }
  /// Sample at a place of this geometry; with the second derivative if `has_curvature`.
  virtual ScalarSample scalar_in(Place&) const noexcept { return {}; }
  virtual VectorSample vector_in(Place&) const noexcept { return {}; }
  virtual ScalarSample scalar_in(Place& place, Mat3& hessian) const noexcept { return hessian = {}, scalar_in(place); }
  virtual bool has_curvature() const noexcept { return false; }
  /// Depth in the box and in its finite part.
  double depth_in(const Place& place) const noexcept {
    const double of_box_m = depth_at(place.steps);
    if (holes_.empty() || !place.inside) return of_box_m;
    const std::int64_t first[3] = {place.cells[0].first - window_.first[0], place.cells[1].first - window_.first[1],
                                   place.cells[2].first - window_.first[2]};
    const double f[3] = {place.cells[0].f, place.cells[1].f, place.cells[2].f};
    return std::min(of_box_m, holes_.depth_m(first, f));
  }
  /// Depth [m] in the box of the whole grid.
  double box_depth_m(const Vec3& world_m) const noexcept { return depth_at(steps_of(world_m)); }
  /// Some values are not finite: the depth is that of this grid, not of its geometry alone.
  bool has_holes() const noexcept { return !holes_.empty(); }
  /// Bound on the length of the change of `count` components from `component` on.
  LipschitzBound certificate_in(const Place& place, int component, int count) const noexcept;

  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    Place place = place_of(world_m);
    return scalar_in(place);
  }
  VectorSample vector(const Vec3& world_m) const noexcept override {
    Place place = place_of(world_m);
    return vector_in(place);
  }
  LipschitzBound lipschitz_bound(const Vec3& world_m) const noexcept override {
    return certificate_in(place_of(world_m), 0, components());
  }

  int components() const noexcept override { return view_.voxels.components; }
  int values_per_sample() const noexcept override {
    return components() * (view_.filter == Filter::trilinear ? 2 * 2 * 2 : 4 * 4 * 4);
  }
  double spacing_m() const noexcept override { return spacing_m_; }
  double local_spacing_m(const Vec3& world_m) const noexcept override;
  bool is_rectilinear() const noexcept { return is_rectilinear_; }
  /// Share [1] of the segment between two positions [m] where it leaves its cell at the share `begin`; 1 outside of cells.
  double end_of_cell(const Vec3& from_m, const Vec3& to_m, double begin) const noexcept;
  Box bounds_m() const noexcept override { return bounds_m_; }
  double depth_m(const Vec3& world_m) const noexcept override;
  std::vector<ValueRange> value_ranges() const override { return extents_; }

  /// Of a vector field: presence of data, without values (degree −1).
  PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                              const ValueRange& quiet) const noexcept override;
  /// `piece_along` of a component.
  PolynomialPiece stretch_of(int component, const Vec3& from_m, const Vec3& to_m, double begin,
                             const ValueRange& quiet) const noexcept;

 protected:
  /// Straight piece across a cell: its first voxel, and the piece's start and end in the cell.
  struct Passage {
    std::int64_t first[3];  ///< [voxels]
    double begin[3];        ///< [1] 0…1 across the cell
    double end[3];          ///< [1] 0…1 across the cell
  };
  /// Sets degree and control of the piece, raw; degree −1 if the raw hull of the cell is quiet. Not finite if a voxel is not.
  virtual void polynomial(int component, const Passage& cell, const ValueRange& quiet,
                          PolynomialPiece& piece) const noexcept = 0;

  /// Whether values between these raw ones stay in the interval.
  bool is_quiet(double raw_min, double raw_max, const ValueRange& quiet) const noexcept {
    const double one = raw_min * view_.scale + view_.offset, other = raw_max * view_.scale + view_.offset;
    return std::min(one, other) >= quiet.min && std::max(one, other) < quiet.max;
  }

  Vec3 gradient_of(const Vec3& d, const Cell (&cells)[3]) const noexcept {
    const Vec3 by_step{d.x * cells[0].per_step, d.y * cells[1].per_step, d.z * cells[2].per_step};
    return transposed_times(world_to_steps_, view_.scale * by_step);
  }

  /// Offset in memory of a voxel's first value.
  std::int64_t offset_of(std::int64_t i, std::int64_t j, std::int64_t k) const noexcept {
    return i * stride_[0] + j * stride_[1] + k * stride_[2] - before_window_;
  }

  GridView view_;
  std::shared_ptr<const void> coefficients_;  ///< interpolated values: the voxels, or coefficients of a spline
  Mat3 world_to_steps_;                       ///< [steps/m]
  std::int64_t stride_[3];                    ///< offset of values from voxel to voxel
  GridWindow window_;                         ///< voxels in memory
  std::int64_t before_window_ = 0;            ///< offset of the first value in memory from the grid's first voxel

 private:
  template <int Axis>
  bool enter(double at, Cell& cell) const noexcept {
    if (!(at >= extent_.low[Axis] && at <= extent_.high[Axis])) return false;
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

  /// Cell along an axis at a position [steps] within the data.
  std::int64_t cell_at(int axis, double at) const noexcept {
    const double clamped = std::min(std::max(at, 0.0), last_[axis]);
    const auto before = planes_[axis] ? plane_before(planes_[axis], cells_[axis], clamped) : static_cast<std::int64_t>(clamped);
    return std::min(before, cells_[axis] - 1);
  }
  double cell_spacing_m(const Cell (&cells)[3]) const noexcept {
    return std::min({plane_distance_m_[0] / cells[0].per_step, plane_distance_m_[1] / cells[1].per_step,
                     plane_distance_m_[2] / cells[2].per_step});
  }
  double depth_at(const Vec3& steps) const noexcept;  ///< [m] within the box
  void find_place(bool is_window);
  void find_extent_of_window(int axis);
  /// Calls `visit(axis, way, side)` for each face of a window behind which the grid goes on, with the way [voxels] to it.
  template <class Visit>
  void for_each_face(const Vec3& steps, Visit&& visit) const noexcept;
  GridGeometry of_memory() const;
  void find_steepest();
  void find_extents(const VoxelFacts& facts);
  void find_holes();
  /// Bound on the change of indices per length [voxels/m], summed over the axes, in the bricks from `low` to `high`.
  double steepest(const std::int64_t (&low)[3], const std::int64_t (&high)[3]) const noexcept;

  /// Last of the planes 0…last at or before a position [steps] >= 0.
  static std::int64_t plane_before(const double* planes, std::int64_t last, double at) noexcept {
    return std::upper_bound(planes + 1, planes + last + 1, at) - planes - 1;
  }

  const Bricks::Range& brick_at(int component, const std::int64_t (&b)[3]) const noexcept {
    const std::int64_t in_window[3] = {b[0] - first_brick_[0], b[1] - first_brick_[1], b[2] - first_brick_[2]};
    return bricks_->at(component, in_window);
  }

  const double* planes_[3];  ///< [steps] positions of the planes of a rectilinear axis; else nullptr
  double spacing_m_ = 0.0;
  double last_[3];         ///< [steps] of the last voxel, also its index
  Extent box_;             ///< [steps] of the whole grid's data
  Extent extent_;          ///< [steps] with the tolerance; of a window its own
  std::int64_t cells_[3];  ///< cells along each axis, at least one
  bool is_rectilinear_ = false;
  double planes_per_m_[3];      ///< [1/m] of the affine
  double plane_distance_m_[3];  ///< between neighbouring planes of voxels, the mean on a rectilinear axis
  Box bounds_m_;
  struct Way;
  /// Crosses whole bricks, quiet or without data, from the entry of one on; false if the segment enters any other brick.
  bool cross_bricks(int component, const Way& way, const ValueRange& quiet, PolynomialPiece& piece) const noexcept;

  bool is_finite_on(int component, const Passage& cell) const noexcept;

  std::vector<ValueRange> extents_;
  Holes holes_;
  std::shared_ptr<const Bricks> bricks_;  ///< of a field with all voxels read
  std::int64_t first_brick_[3];           ///< of the window
  std::vector<double> finest_in_[3];      ///< [1] the most indices per step in each brick along a rectilinear axis
  double steepest_per_m_ = 0.0;           ///< `steepest` of a grid without such axes
};

}  // namespace palpa::detail
