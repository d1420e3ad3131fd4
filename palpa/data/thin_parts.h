// What the smoothing filter loses of thin parts.
#pragma once

#include <cstdint>

#include "palpa/data/field.h"

namespace palpa {

/// Which side of a level is solid.
enum class SolidSide : std::uint8_t { high, low };

/// Counts of voxels of a grid. A voxel is solid where its value is on the solid side of the level or on it. It is thin where
/// no block of 2 × 2 × 2 solid voxels holds it (it falls in a morphological opening with that block): the solid is
/// thinner there than two voxels along some axis. A thin voxel is lost where the smoothing spline, sampled at
/// the voxel, gives a value beyond the level: what was solid is not felt there any more.
struct ThinParts {
  std::int64_t solid = 0;  ///< [voxels]
  std::int64_t thin = 0;   ///< [voxels] of the solid ones
  std::int64_t lost = 0;   ///< [voxels] of the thin ones
  /// [1] lost of thin; 0 where nothing is thin.
  double lost_share() const noexcept { return thin > 0 ? static_cast<double>(lost) / static_cast<double>(thin) : 0.0; }
  /// [1] thin of solid; 0 where nothing is solid.
  double thin_share() const noexcept { return solid > 0 ? static_cast<double>(thin) / static_cast<double>(solid) : 0.0; }
};

/// Counts over the grid behind a field, a posed one too, whatever its filter; of a series over its first frame. Voxels that are
/// not finite are not solid, and a voxel beside one is not lost, as there is no value to compare with. Along an axis of one
/// voxel thickness is not looked at. Uses as many threads as there are cores; scratch memory is a few slices for each. Throws
/// std::invalid_argument, with a sentence, on a field without voxels or of vectors. \param level  in the field's own unit
ThinParts thin_parts(const Field& field, double level, SolidSide solid = SolidSide::high);

}  // namespace palpa
