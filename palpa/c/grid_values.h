// Grids of C as volumes.
#pragma once

#include "palpa/c.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"

namespace palpa::c {

/// Geometry of a grid of a known size, without looking at voxels. Throws WrongArgument.
GridGeometry geometry_of(const palpa_grid& grid);
/// Copy of the voxels of a grid of a known size. Throws WrongArgument, also for the grid's other numbers.
Voxels voxels_of(const palpa_grid& grid);
/// Volume of a field "data" likewise. Throws WrongArgument.
Volume volume_of(const palpa_grid& grid);

}  // namespace palpa::c
