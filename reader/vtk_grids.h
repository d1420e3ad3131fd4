// Affine and rectilinear grids of VTK.
#pragma once

#include <vtkDataSet.h>

#include <array>
#include <optional>
#include <vector>

#include "palpa/data/grid.h"

namespace palpa::reader {

/// Grids of the points and of the cells of one data set, in the file's unit of length. Cell data are at the centres of cells,
/// or at the point on an axis of one point.
struct PointsAndCells {
  GridGeometry points, cells;
};
/// Grids of planes at these coordinates, along the columns of `directions`, from `origin`.
PointsAndCells grids_of(const std::array<std::vector<double>, 3>& coordinates, const Mat3& directions, const Vec3& origin);
/// Grids of image data, whose first index is arbitrary.
PointsAndCells grids_of(const int extent[6], const double origin[3], const double spacing[3], const double direction[9]);

/// Own grids of a data set if it is affine or rectilinear and has no blanks; else none. Throws LoadError.
std::optional<PointsAndCells> own_grids(vtkDataSet& data);

}  // namespace palpa::reader
