#include "cell_values.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdTypeArray.h>
#include <vtkPointData.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <limits>

#include "palpa/base/load_error.h"

namespace palpa::reader {

void check_cells(vtkDataSet& block) {
  if (auto* grid = vtkStructuredGrid::SafeDownCast(&block)) {
    int dims[3];
    grid->GetDimensions(dims);
    if (grid->GetNumberOfPoints() != vtkIdType{dims[0]} * dims[1] * dims[2])
      throw LoadError("has not all points of its grid; get the whole file");
  }
  auto* mesh = vtkUnstructuredGrid::SafeDownCast(&block);
  if (mesh == nullptr) return;
  const vtkIdType points = mesh->GetNumberOfPoints();
  const auto check = [&](vtkIdType count, const vtkIdType* ids, int least) {
    if (count < least || std::any_of(ids, ids + count, [&](vtkIdType id) { return id < 0 || id >= points; }))
      throw LoadError("has a cell with points that are not there; export it again");
  };
  const vtkUnsignedCharArray* types = mesh->GetCellTypesArray();
  if (types == nullptr || types->GetNumberOfValues() != mesh->GetCells()->GetNumberOfCells() || !mesh->GetCells()->IsValid())
    throw LoadError("has cells that do not fit together; export it again");
  std::array<int, VTK_NUMBER_OF_CELL_TYPES> corners{};  // least number by shape, 0: any number; -1: not yet known
  corners.fill(-1);
  vtkNew<vtkIdList> ids;
  for (vtkIdType cell = 0; cell < mesh->GetNumberOfCells(); ++cell) {
    const int type = mesh->GetCellType(cell);
    if (type < 0 || type >= VTK_NUMBER_OF_CELL_TYPES)
      throw LoadError("has a cell of type " + std::to_string(type) + ", which is unknown; export it again");
    int& least = corners[static_cast<std::size_t>(type)];
    if (least < 0) {
      const auto shape = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(type));
      least = shape != nullptr ? static_cast<int>(shape->GetNumberOfPoints()) : 0;
    }
    mesh->GetCells()->GetCellAtId(cell, ids);
    check(ids->GetNumberOfIds(), ids->GetPointer(0), least);
    if (type != VTK_POLYHEDRON) continue;
    // A polyhedron is stored as the number of its faces, then for each face the number of its points and the points.
    const vtkIdTypeArray *all = mesh->GetFaces(), *starts = mesh->GetFaceLocations();
    const vtkIdType end = all != nullptr ? all->GetNumberOfValues() : 0;
    vtkIdType at = starts != nullptr && cell < starts->GetNumberOfValues() ? starts->GetValue(cell) : end;
    const auto next = [&] {
      if (at < 0 || at >= end) throw LoadError("has a polyhedron without its faces; export it again");
      return all->GetValue(at++);
    };
    for (vtkIdType face = next(); face > 0; --face) {
      for (vtkIdType corner = next(); corner > 0; --corner) {
        const vtkIdType id = next();
        check(1, &id, 1);
      }
    }
  }
}

bool is_visible(vtkPointSet& block, vtkIdType cell) {
  const vtkUnsignedCharArray* ghosts = block.GetCellGhostArray();
  return ghosts == nullptr ||
         (const_cast<vtkUnsignedCharArray*>(ghosts)->GetValue(cell) & vtkDataSetAttributes::HIDDENCELL) == 0;
}

bool CellAt::narrow(double low_z, double high_z, double (&low)[2], double (&high)[2]) const {
  constexpr vtkIdType most_points = 16;  // more: checking all pairs costs more than the search in each voxel
  const vtkIdType count = cell->GetNumberOfPoints();
  if (count > most_points || cell->IsLinear() == 0) return true;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double least[2] = {infinity, infinity}, most[2] = {-infinity, -infinity};
  for (vtkIdType one = 0; one < count; ++one) {
    for (vtkIdType other = 0; other < one; ++other) {
      double a[3], b[3];
      cell->GetPoints()->GetPoint(one, a);
      cell->GetPoints()->GetPoint(other, b);
      if (a[2] > b[2]) std::swap(a, b);
      if (a[2] > high_z || b[2] < low_z) continue;
      const double height = b[2] - a[2];
      const double from = height > 0.0 ? std::max(0.0, (low_z - a[2]) / height) : 0.0;
      const double to = height > 0.0 ? std::min(1.0, (high_z - a[2]) / height) : 1.0;
      for (int axis = 0; axis < 2; ++axis) {
        for (const double share : {from, to}) {
          const double at = a[axis] + share * (b[axis] - a[axis]);
          least[axis] = std::min(least[axis], at), most[axis] = std::max(most[axis], at);
        }
      }
    }
  }
  for (int axis = 0; axis < 2; ++axis)
    low[axis] = std::max(low[axis], least[axis]), high[axis] = std::min(high[axis], most[axis]);
  return low[0] <= high[0] && low[1] <= high[1];
}

PointValues::PointValues(vtkPointSet& block, const std::vector<ArrayName>& arrays) {
  for (const ArrayName& array : arrays) components.push_back(array.components), per_point += array.components;
  const vtkIdType points = block.GetNumberOfPoints();
  numbers.assign(static_cast<std::size_t>(points * per_point), std::numeric_limits<float>::quiet_NaN());
  int at = 0;
  for (const ArrayName& array : arrays) {
    vtkFieldData& data = array.of_cells ? static_cast<vtkFieldData&>(*block.GetCellData()) : *block.GetPointData();
    vtkDataArray* from = data.GetArray(array.name.c_str());
    const vtkIdType count = array.of_cells ? block.GetNumberOfCells() : points;
    if (from == nullptr || from->GetNumberOfComponents() != array.components || from->GetNumberOfTuples() != count) {
      throw LoadError("has not all values of array '" + array.name + "'; check that the file is whole");
    }
    if (array.of_cells) {
      average(block, *from, at);
    } else {
      for (vtkIdType p = 0; p < points; ++p) {
        for (int c = 0; c < array.components; ++c) number(p, at + c) = static_cast<float>(from->GetComponent(p, c));
      }
    }
    at += array.components;
  }
}

/// Mean of the cells around each point.
void PointValues::average(vtkPointSet& block, vtkDataArray& from, int at) {
  std::vector<float> weights(static_cast<std::size_t>(block.GetNumberOfPoints()));
  const int count = from.GetNumberOfComponents();
  vtkNew<vtkIdList> points;
  for (vtkIdType cell = 0; cell < block.GetNumberOfCells(); ++cell) {
    if (!is_visible(block, cell)) continue;
    block.GetCellPoints(cell, points);
    for (vtkIdType n = 0; n < points->GetNumberOfIds(); ++n) {
      const vtkIdType p = points->GetId(n);
      float& weight = weights[static_cast<std::size_t>(p)];
      for (int c = 0; c < count; ++c) {
        float& mean = number(p, at + c);
        const auto value = static_cast<float>(from.GetComponent(cell, c));
        mean = weight == 0.0F ? value : mean + (value - mean) / (weight + 1.0F);
      }
      weight += 1.0F;
    }
  }
}

}  // namespace palpa::reader
