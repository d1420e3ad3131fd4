// The cells of data sets of VTK, and the values at any place in them, by the cells' own shape functions.
#pragma once

#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

namespace palpa::reader {

/// An array of a data set, of its points or of its cells.
struct ArrayName {
  std::string name;
  bool of_cells = false;
  int components = 1;
};

/// Throws LoadError where points of cells are missing, or too few for a cell's shape: VTK reads them without any check.
void check_cells(vtkDataSet& block);

/// Whether a cell is data, not hidden.
bool is_visible(vtkPointSet& block, vtkIdType cell);

/// The numbers of the wanted arrays at the points of one block, all of a point together.
struct PointValues {
  int per_point = 0;
  std::vector<int> components;
  std::vector<float> numbers;

  /// Values of cells are averaged to the points. Throws LoadError where an array is not whole.
  PointValues(vtkPointSet& block, const std::vector<ArrayName>& arrays);

  float& number(vtkIdType point, int at) { return numbers[static_cast<std::size_t>(point * per_point + at)]; }
  const float* of(vtkIdType point) const { return numbers.data() + point * per_point; }

 private:
  void average(vtkPointSet& block, vtkDataArray& from, int at);
};

/// Whether a place lies in a cell, and the values there; each thread has its own.
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
  /// Narrows a box, in x and y, to where the cell can be between two heights: damaged cells are long and thin, and fill little
  /// of the layers that they reach through. A cell of straight edges lies within the convex hull of its points, and that
  /// between the heights within the bounds of all ways from point to point; others are left as they are. False: it is not
  /// there.
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
