#include "vtk_grids.h"

#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "palpa/base/load_error.h"

namespace palpa::reader {
namespace {

bool hides(vtkUnsignedCharArray* ghosts, unsigned char kind) {
  for (vtkIdType n = 0; ghosts != nullptr && n < ghosts->GetNumberOfTuples(); ++n) {
    if ((ghosts->GetValue(n) & kind) != 0) return true;
  }
  return false;
}
/// True if points or cells are hidden: voxels, which all have values, cannot represent that.
bool has_blanks(vtkDataSet& data) {
  return hides(data.GetPointGhostArray(), vtkDataSetAttributes::HIDDENPOINT) ||
         hides(data.GetCellGhostArray(), vtkDataSetAttributes::HIDDENCELL);
}

Vec3 point_of(vtkDataSet& data, std::int64_t i, std::int64_t j, std::int64_t k, const int (&dims)[3]) {
  double at[3];
  data.GetPoint(i + dims[0] * (j + dims[1] * k), at);
  return {at[0], at[1], at[2]};
}

/// Grids of a structured grid whose points lie on straight planes along three directions: in fact rectilinear.
std::optional<PointsAndCells> straight_grids(vtkStructuredGrid& grid) {
  int dims[3];
  grid.GetDimensions(dims);
  double bounds[6];
  grid.GetBounds(bounds);
  const Vec3 first = point_of(grid, 0, 0, 0, dims);
  Vec3 along[3];
  std::array<std::vector<double>, 3> coordinates;
  double largest = 0.0;
  for (const double bound : bounds) largest = std::max(largest, std::abs(bound));
  const double rounding = 2.0 * static_cast<double>(std::numeric_limits<float>::epsilon()) * largest;
  for (int a = 0; a < 3; ++a) {
    if (dims[a] < 2) return std::nullopt;
    const auto at = [&](int n) { return point_of(grid, a == 0 ? n : 0, a == 1 ? n : 0, a == 2 ? n : 0, dims); };
    along[a] = normalized(at(dims[a] - 1) - first);
    for (int n = 0; n < dims[a]; ++n) coordinates[static_cast<std::size_t>(a)].push_back(dot(at(n) - first, along[a]));
  }
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const Vec3 straight = first + coordinates[0][static_cast<std::size_t>(i)] * along[0] +
                              coordinates[1][static_cast<std::size_t>(j)] * along[1] +
                              coordinates[2][static_cast<std::size_t>(k)] * along[2];
        if (!(largest_component(point_of(grid, i, j, k, dims) - straight) <= rounding)) return std::nullopt;
      }
    }
  }
  try {
    return grids_of(coordinates, transposed(Mat3{{along[0], along[1], along[2]}}), first);
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // straight, but planes are out of order
  }
}

std::vector<double> numbers_of(vtkDataArray* array) {
  std::vector<double> numbers;
  for (vtkIdType n = 0; array != nullptr && n < array->GetNumberOfTuples(); ++n) numbers.push_back(array->GetComponent(n, 0));
  return numbers;
}

}  // namespace

PointsAndCells grids_of(const std::array<std::vector<double>, 3>& coordinates, const Mat3& directions, const Vec3& origin) {
  std::array<std::vector<double>, 3> centres;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t i = 1; i < coordinates[a].size(); ++i)
      centres[a].push_back(0.5 * (coordinates[a][i - 1] + coordinates[a][i]));
    if (centres[a].empty()) centres[a] = coordinates[a];
  }
  const auto turned = [&](GridGeometry grid) {
    grid.index_to_world_m = directions * grid.index_to_world_m;
    grid.origin_m = directions * grid.origin_m + origin;
    return grid;
  };
  return {turned(rectilinear_geometry(coordinates)), turned(rectilinear_geometry(centres))};
}

PointsAndCells grids_of(const int extent[6], const double origin[3], const double spacing[3], const double direction[9]) {
  GridGeometry points, cells;
  double first[3], centre[3];
  for (int a = 0; a < 3; ++a) {
    if (extent[2 * a + 1] < extent[2 * a]) throw LoadError("has no voxels; the grid's extent is empty");
    const std::int64_t count = std::int64_t{extent[2 * a + 1]} - extent[2 * a] + 1;
    points.dims[static_cast<std::size_t>(a)] = count;
    cells.dims[static_cast<std::size_t>(a)] = std::max<std::int64_t>(count - 1, 1);
    const double* d = direction + 3 * a;
    points.index_to_world_m.row[a] = {d[0] * spacing[0], d[1] * spacing[1], d[2] * spacing[2]};
    first[a] = static_cast<double>(extent[2 * a]);
    centre[a] = first[a] + (count > 1 ? 0.5 : 0.0);
  }
  cells.index_to_world_m = points.index_to_world_m;
  const Vec3 start{origin[0], origin[1], origin[2]};
  points.origin_m = points.index_to_world_m * Vec3{first[0], first[1], first[2]} + start;
  cells.origin_m = points.index_to_world_m * Vec3{centre[0], centre[1], centre[2]} + start;
  return {points, cells};
}

std::optional<PointsAndCells> own_grids(vtkDataSet& data) {
  if (has_blanks(data)) return std::nullopt;
  if (auto* image = vtkImageData::SafeDownCast(&data)) {
    return grids_of(image->GetExtent(), image->GetOrigin(), image->GetSpacing(), image->GetDirectionMatrix()->GetData());
  }
  if (auto* grid = vtkRectilinearGrid::SafeDownCast(&data)) {
    try {
      return grids_of(
          {numbers_of(grid->GetXCoordinates()), numbers_of(grid->GetYCoordinates()), numbers_of(grid->GetZCoordinates())},
          Mat3::identity(), {});
    } catch (const std::invalid_argument& problem) {
      throw LoadError(std::string("cannot be placed in the world (") + problem.what() + "); correct its coordinates");
    }
  }
  auto* grid = vtkStructuredGrid::SafeDownCast(&data);
  return grid != nullptr ? straight_grids(*grid) : std::nullopt;
}

}  // namespace palpa::reader
