// Affine grids: voxels in their own type, a general affine from index to world, trilinear sampling.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "palpa/data/field.h"

namespace palpa {

namespace detail {
struct VoxelFacts;
}

enum class VoxelType : std::uint8_t { uint8, int16, uint16, int32, float32, float64 };

const char* name_of(VoxelType type) noexcept;
std::size_t size_of(VoxelType type) noexcept;  ///< bytes of one component

/// Position in voxel indices: (0, 0, 0) is the centre of the first voxel. Not metres.
struct GridPoint {
  double i = 0.0;  ///< [voxels]
  double j = 0.0;  ///< [voxels]
  double k = 0.0;  ///< [voxels]
  friend constexpr bool operator==(const GridPoint&, const GridPoint&) = default;
};

/// Geometry of a grid: number of voxels along each axis and the affine from index to world. Any regular affine, also sheared or
/// mirrored, so that a tilted CT need not be resampled.
///
/// A rectilinear grid has planes of voxels at uneven distances: the step of its affine is their mean distance, `planes` are
/// their positions along the axis.
struct GridGeometry {
  std::array<std::int64_t, 3> dims{1, 1, 1};  ///< voxels along i (fastest in memory), j, k; >= 1 each
  Mat3 index_to_world_m = Mat3::identity();   ///< [m] column = step of one index
  Vec3 origin_m;                              ///< [m] world position of index (0, 0, 0)
  /// For each axis the positions of its planes [steps of the affine], rising from 0 to dims − 1; empty: 0, 1, 2, …
  std::array<std::vector<double>, 3> planes{};

  friend bool operator==(const GridGeometry&, const GridGeometry&) = default;
  /// World position [m] of a grid position; linear between planes, and beyond the last, along each axis.
  Vec3 to_world(const GridPoint& p) const noexcept {
    return index_to_world_m * (is_rectilinear() ? among_planes(p) : Vec3{p.i, p.j, p.k}) + origin_m;
  }
  /// Grid position along each axis [steps of the affine].
  Vec3 among_planes(const GridPoint& p) const noexcept;
  bool is_rectilinear() const noexcept { return !planes[0].empty() || !planes[1].empty() || !planes[2].empty(); }
  std::int64_t voxels() const noexcept { return dims[0] * dims[1] * dims[2]; }
};

/// Fault of the geometry, as a sentence without its dot; nullptr if valid.
const char* problem_with(const GridGeometry& geometry) noexcept;

/// Grid with planes along x, y and z at these coordinates [m], each list rising or falling. An axis of evenly spaced
/// coordinates (to their rounding as floats) becomes affine, without `planes`; an axis of one coordinate gets the least mean
/// step of the others. Throws std::invalid_argument, with a sentence, on invalid coordinates.
GridGeometry rectilinear_geometry(const std::array<std::vector<double>, 3>& coordinates_m);

/// Voxels in memory: i fastest, components of a voxel together. `data` owns the memory.
struct Voxels {
  VoxelType type = VoxelType::float32;
  int components = 1;  ///< 1 or 3
  std::shared_ptr<const void> data;
  /// Ranges found by a grid of these voxels, so that another need not read them again. Set by grids only; leave it empty.
  std::shared_ptr<const detail::VoxelFacts> facts{};
};

/// Interpolation of a grid between its voxels.
enum class Filter : std::uint8_t {
  trilinear,  ///< linear from voxel to voxel (`grid_field`)
  smooth,     ///< smoothing cubic B-spline: the voxels are its coefficients (`smooth_grid_field`)
  cubic,      ///< interpolating cubic B-spline: it equals the voxels there (`cubic_grid_field`)
};
const char* name_of(Filter filter) noexcept;

/// Field on an affine grid: value = raw · scale + offset, trilinear between voxel centres, with the analytic derivative of that
/// interpolant. `inside` from the first to the last voxel centre of every axis (less than a millionth of a voxel beyond counts
/// as on it); not in a cell with a non-finite voxel, nor where value or derivative overflow a double. An axis of one voxel has
/// no extent: the field is constant across it, half a voxel to either side. Between uneven planes every filter works in index
/// space, cell by cell, so that the derivative steps where distances do.
///
/// Reads all voxels once for their range, on all cores; throws std::invalid_argument, with a sentence, on invalid geometry,
/// voxels, `scale` [unit] or `offset` [unit]. `voxels.data` must hold geometry.voxels() × components values, unchecked.
FieldPtr grid_field(const GridGeometry& geometry, Voxels voxels, double scale = 1.0, double offset = 0.0);

/// `grid_field` for display only: reads one row along i in `one_row_in` (1 or more), for the range of those rows, and keeps no
/// ranges of parts: `piece_along` goes cell by cell. `scale` [unit], `offset` [unit].
FieldPtr preview_grid_field(const GridGeometry& geometry, Voxels voxels, double scale, double offset, std::int64_t one_row_in);

/// Arguments of a field on a grid.
struct GridView {
  GridGeometry geometry;
  Voxels voxels;
  double scale = 1.0;        ///< the field's own unit, per raw step
  double offset = 0.0;       ///< the field's own unit
  double valid_share = 1.0;  ///< [1] share of voxels with all components finite
  Filter filter = Filter::trilinear;
  bool signless = false;  ///< an axis field: v and −v in a voxel are equivalent (`signless`)
};
/// Grid behind any field on a grid, with any filter; nullptr for formulas, posed fields and fields computed from another
/// field's sample. Valid as long as the field.
const GridView* grid_behind(const Field& field) noexcept;
/// `grid_behind` for a field made by `grid_field` alone; nullptr for other fields.
const GridView* grid_of(const Field& field) noexcept;

/// The field's voxels with another filter, under its pose, in every frame of a series; the field itself if it has that filter
/// already. Allocates, and for Filter::cubic copies the voxels. Throws std::invalid_argument, with a sentence, on a field
/// without voxels (a formula, a derived value), and on Filter::cubic for whole numbers and for axis fields.
FieldPtr filtered(FieldPtr field, Filter filter);

/// Vector grid as an axis field, in which v and −v are equivalent, with its voxels, filter (smooth instead of cubic) and pose.
/// Throws std::invalid_argument, with a sentence, on fields without voxels and on scalar ones.
FieldPtr signless(FieldPtr field);

}  // namespace palpa
