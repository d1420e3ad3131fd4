// Which filter a grid gets, and what it takes away.
#pragma once

#include <optional>

#include "palpa/data/grid.h"

namespace palpa {

/// What lies between the voxels of a grid where nobody says otherwise, and why.
struct FilterChoice {
  Filter filter = Filter::trilinear;
  const char* why = "";               ///< half a sentence
  std::optional<double> roughness{};  ///< [1] of the voxels, if it was asked for (`roughness`)
};
/// Of whole numbers the smoothing spline, which evens out their steps. Of scalar fractions a spline, too, so that normals do
/// not jump from voxel to voxel: the one that meets the voxels where they are smooth enough for that (roughness below 1), as
/// in formulas and flows without shocks, else, as in scans, the one that smooths, which needs no memory of its own.
/// Trilinear of vectors of fractions, whose directions are values; where planes lie at uneven distances, because splines in
/// index space would bend what is straight there; and of fewer than five voxels along every axis. Reads a few thousand
/// voxels.
FilterChoice default_filter(const GridView& grid) noexcept;

/// How little voxels tell of what lies between them [1]: fourth differences over second ones, squared, summed, along the worst
/// axis, at up to 8192 places of each. A wave of length λ voxels has (2 sin π/λ)⁴: 0.1 at 11 voxels, 1 at 6, 4 at 4;
/// noise from voxel to voxel has 11.7, an edge of one voxel 10. 0 where there is nothing but rounding, and on axes of fewer
/// than five voxels.
double roughness(const GridView& grid) noexcept;

/// The grid behind a field, below its poses, and of a series its first frame: its geometry need not be that of the world.
/// nullptr where there is none.
const GridView* grid_below(const Field& field) noexcept;

/// Whether a field has detail finer than its filter: a scalar one on a grid with the filter `smooth`, which keeps the voxels
/// and does not meet them; also under a pose, and in the frames of a series. Formulas, magnitudes and components have none.
bool has_detail(const Field& field) noexcept;

}  // namespace palpa
