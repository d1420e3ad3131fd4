#include "cell_values.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <limits>

#include "palpa/core/load_error.h"

namespace palpa::reader {

bool is_visible(vtkPointSet& block, vtkIdType cell) {
  const vtkUnsignedCharArray* ghosts = block.GetCellGhostArray();
  return ghosts == nullptr ||
         (const_cast<vtkUnsignedCharArray*>(ghosts)->GetValue(cell) & vtkDataSetAttributes::HIDDENCELL) == 0;
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

/// The mean of the cells around each point.
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
