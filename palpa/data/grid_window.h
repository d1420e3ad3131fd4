// Part of a large grid in memory.
#pragma once

#include <array>
#include <cstdint>

#include "palpa/data/grid.h"

namespace palpa {

/// Part of a grid whose voxels are in memory, as a box of voxels of the whole grid.
struct GridWindow {
  std::array<std::int64_t, 3> first{};  ///< [voxels] along i, j, k; multiples of 8, where ranges of whole bricks begin
  std::array<std::int64_t, 3> dims{};   ///< [voxels] along i, j, k
  /// [steps] Data of the whole grid are between these positions along each axis: less than from the first to the last voxel,
  /// where border voxels were added.
  std::array<double, 3> data_low{}, data_high{};
};

/// Field on a part of a grid: wherever all voxels of a sample are in the window it is that of the whole grid, to the bit, as
/// are pieces, bounds and depths of the box; elsewhere it has no data. Ranges and holes are those of the window. Reads the
/// window's voxels. Allocates. Throws std::invalid_argument as `grid_field`, and on a window that is not within the grid, on a
/// rectilinear grid, and on Filter::cubic, whose coefficients would depend on the window.
/// \param whole   geometry of the whole grid
/// \param voxels  of the window
/// \param scale   the field's own unit, per raw step
/// \param offset  the field's own unit
FieldPtr window_field(const GridGeometry& whole, const GridWindow& window, Voxels voxels, Filter filter, double scale = 1.0,
                      double offset = 0.0);

}  // namespace palpa
