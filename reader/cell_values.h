// Cells of VTK data sets, and values inside them by the cells' shape functions.
#pragma once

#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

namespace palpa::reader {

struct ArrayName {
  std::string name;
  bool of_cells = false;
  int components = 1;
};

/// Throws LoadError if a cell refers to missing points or has too few for its shape: VTK reads them unchecked.
void check_cells(vtkDataSet& block);

/// True if a cell is data, not hidden.
bool is_visible(vtkPointSet& block, vtkIdType cell);

/// Values of the wanted arrays at the points of one block, grouped by point.
struct PointValues {
  int per_point = 0;
  std::vector<int> components;
  std::vector<float> numbers;

  /// Averages cell values to the points. Throws LoadError if an array is incomplete.
  PointValues(vtkPointSet& block, const std::vector<ArrayName>& arrays);

  float& number(vtkIdType point, int at) { return numbers[static_cast<std::size_t>(point * per_point + at)]; }
  const float* of(vtkIdType point) const { return numbers.data() + point * per_point; }

 private:
  void average(vtkPointSet& block, vtkDataArray& from, int at);
};

/// Test of a position against a cell, and the values there. One object per thread.
struct CellAt {
  vtkNew<vtkGenericCell> cell;
  std::vector<double> weights;
  std::vector<float> found;

  explicit CellAt(const std::vector<vtkSmartPointer<vtkPointSet>>& blocks) {
    int most = 8;
    for (const auto& block : blocks) most = std::max(most, static_cast<int>(block->GetMaxCellSize()));
    weights.resize(static_cast<std::size_t>(most));
  }
  bool holds(const double (&at)[3]) {
    double closest[3], parametric[3], distance2 = 0.0;
    int sub = 0;
    return cell->EvaluatePosition(at, closest, sub, parametric, distance2, weights.data()) == 1;
  }
  /// Narrows a box in x and y to the cell's part between two heights: damaged cells are long and thin, and fill little of their
  /// layers. A cell with straight edges is within the convex hull of its points, and its part between the heights within the
  /// bounds of all segments between points; for other cells the box stays. False: no part of the cell.
  bool narrow(double low_z, double high_z, double (&low)[2], double (&high)[2]) const;
  const float* values(const PointValues& of) {
    found.assign(static_cast<std::size_t>(of.per_point), 0.0F);
    for (vtkIdType n = 0; n < cell->GetNumberOfPoints(); ++n) {
      const float* point = of.of(cell->GetPointId(static_cast<int>(n)));
      const auto weight = static_cast<float>(weights[static_cast<std::size_t>(n)]);
      for (int c = 0; c < of.per_point; ++c) found[static_cast<std::size_t>(c)] += weight * point[c];
    }
    return found.data();
  }
};

}  // namespace palpa::reader
