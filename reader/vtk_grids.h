// Affine and rectilinear grids of VTK.
#pragma once

#include <vtkDataSet.h>

#include <array>
#include <optional>
#include <vector>

#include "palpa/grid/grid.h"

namespace palpa::reader {

/// The grids of the points and of the cells of one data set, in the file's unit of length. Cell data lie at the centres of
/// cells; an axis of one point has them there.
struct PointsAndCells {
  GridGeometry points, cells;
};
/// Of planes at these coordinates along the columns of `directions` from `origin`.
PointsAndCells grids_of(const std::array<std::vector<double>, 3>& coordinates, const Mat3& directions, const Vec3& origin);
/// Of image data whose indices begin anywhere.
PointsAndCells grids_of(const int extent[6], const double origin[3], const double spacing[3], const double direction[9]);

/// The own grid of a data set, where it is affine or rectilinear and all of it is data. Throws LoadError.
std::optional<PointsAndCells> own_grids(vtkDataSet& data);

}  // namespace palpa::reader
