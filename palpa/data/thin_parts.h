// Loss of thin parts by the smoothing filter.
#pragma once

#include <cstdint>

#include "palpa/data/field.h"

namespace palpa {

/// Solid side of a level.
enum class SolidSide : std::uint8_t { high, low };

/// Counts of voxels of a grid. A voxel is solid if its value is at the level or on its solid side. It is thin if no block of 2
/// × 2 × 2 solid voxels contains it (a morphological opening with that block removes it): the solid is thinner there than two
/// voxels along some axis. A thin voxel is lost if the smoothing spline at the voxel is beyond the level: that solid is not
/// felt any more.
struct ThinParts {
  std::int64_t solid = 0;  ///< [voxels]
  std::int64_t thin = 0;   ///< [voxels] of the solid ones
  std::int64_t lost = 0;   ///< [voxels] of the thin ones
  /// [1] lost of thin; 0 without thin voxels.
  double lost_share() const noexcept { return thin > 0 ? static_cast<double>(lost) / static_cast<double>(thin) : 0.0; }
  /// [1] thin of solid; 0 without solid voxels.
  double thin_share() const noexcept { return solid > 0 ? static_cast<double>(thin) / static_cast<double>(solid) : 0.0; }
};

/// Counts over the grid behind a field, also a posed one, for any filter; of a series over its first frame. Non-finite voxels
/// are not solid, and a voxel beside one is not lost, for lack of a value to compare. Ignores thickness along an axis of one
/// voxel. Uses all cores; scratch memory is a few slices per thread. Throws std::invalid_argument, with a sentence, on a field
/// without voxels or of vectors.
/// \param level  in the field's own unit
ThinParts thin_parts(const Field& field, double level, SolidSide solid = SolidSide::high);

}  // namespace palpa
