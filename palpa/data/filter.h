// Default filters of grids, and their loss of detail.
#pragma once

#include <optional>

#include "palpa/data/grid.h"

namespace palpa {

/// Default filter of a grid, with its reason.
struct FilterChoice {
  Filter filter = Filter::trilinear;
  const char* why = "";               ///< half a sentence
  std::optional<double> roughness{};  ///< [1] of the voxels, if computed (`roughness`)
};
/// Whole numbers: the smoothing spline, which evens out their steps. Scalar fractions: a spline, too, for continuous normals:
/// the interpolating one for smooth voxels (roughness below 1), as in formulas and flows without shocks, else, as in scans, the
/// smoothing one, which needs no memory of its own. Trilinear for vectors of fractions, whose directions are values; for planes
/// at uneven distances, because splines in index space would bend straight data; and for fewer than five voxels along every
/// axis. Reads a few thousand voxels.
FilterChoice default_filter(const GridView& grid) noexcept;

/// Roughness [1]: how badly voxels determine values between them, as fourth differences over second ones, squared, summed,
/// along the worst axis, at up to 8192 places of each. A wave of length λ voxels has (2 sin π/λ)⁴: 0.1 at 11 voxels, 1 at 6, 4
/// at 4; noise from voxel to voxel has 11.7, an edge of one voxel 10. 0 for rounding alone, and on axes of fewer than five
/// voxels.
double roughness(const GridView& grid) noexcept;

/// Grid behind a field, below its poses, and of a series its first frame: its geometry need not be that of the world. nullptr
/// if none.
const GridView* grid_below(const Field& field) noexcept;

/// Whether a field has detail finer than its filter: a scalar grid with the filter `smooth`, which does not interpolate its
/// voxels; also under a pose, and in the frames of a series. Formulas, magnitudes and components have none.
bool has_detail(const Field& field) noexcept;

}  // namespace palpa
