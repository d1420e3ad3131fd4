// Affine grids: voxels in their own type, one general affine from index to world, trilinear sampling.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "palpa/field/field.h"

namespace palpa {

enum class VoxelType : std::uint8_t { uint8, int16, uint16, int32, float32, float64 };

const char* name_of(VoxelType type) noexcept;     ///< "uint8", …
std::size_t size_of(VoxelType type) noexcept;     ///< bytes of one component

/// A position in voxel indices: (0, 0, 0) is the centre of the first voxel. Not metres.
struct GridPoint {
  double i = 0.0;
  double j = 0.0;
  double k = 0.0;
  friend constexpr bool operator==(const GridPoint&, const GridPoint&) = default;
};

/// Where a grid lies: number of voxels along each axis and the affine from index to world. Any regular
/// affine, sheared or mirrored too: a tilted CT is never resampled.
struct GridGeometry {
  std::array<std::int64_t, 3> dims{1, 1, 1};  ///< voxels along i (fastest in memory), j, k; >= 1 each
  Mat3 index_to_world_m = Mat3::identity();   ///< [m] column = step of one index
  Vec3 origin_m;                              ///< [m] world position of index (0, 0, 0)

  friend bool operator==(const GridGeometry&, const GridGeometry&) = default;
  Vec3 to_world(const GridPoint& p) const noexcept { return index_to_world_m * Vec3{p.i, p.j, p.k} + origin_m; }
  std::int64_t voxels() const noexcept { return dims[0] * dims[1] * dims[2]; }
};

/// What is wrong with the geometry, as half a sentence; nullptr when it can be used.
const char* problem_with(const GridGeometry& geometry) noexcept;

/// Voxels in memory: i fastest, components of one voxel together. The memory belongs to `data`.
struct Voxels {
  VoxelType type = VoxelType::float32;
  int components = 1;  ///< 1 or 3
  std::shared_ptr<const void> data;
};

/// A field on an affine grid: value = raw · scale + offset, trilinear between voxel centres, with the
/// analytic derivative of that interpolant. `inside` from the first to the last voxel centre of every
/// axis; a cell with a voxel that is not finite is outside. An axis of one voxel has no extent: the
/// field is constant across it, half a voxel to either side.
///
/// The constructor reads all voxels once for the range; it throws std::invalid_argument, with a
/// sentence, where geometry or voxels cannot be used.
FieldPtr grid_field(const GridGeometry& geometry, Voxels voxels, double scale = 1.0, double offset = 0.0);

/// Any field as a grid of float32 over its box, `longest` (>= 2) samples along the longest side, so
/// that data without a file go the same way as data from one.
FieldPtr sampled(const Field& field, int longest);
/// Every field of a volume as a grid.
Volume sampled(const Volume& volume, int longest);

/// The grid behind a field made by `grid_field`; nullptr for other fields. For `info` and tests.
struct GridView {
  GridGeometry geometry;
  Voxels voxels;
  double scale = 1.0;
  double offset = 0.0;
  double valid_share = 1.0;  ///< [1] share of voxels whose components are all finite
};
const GridView* grid_of(const Field& field) noexcept;

}  // namespace palpa
