// Fields, paths and transfer functions as VTK objects. Header-only, for any VTK of the user.
#pragma once

#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkLongLongArray.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkShortArray.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnsignedShortArray.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/data/grid.h"
#include "palpa/mode/parameters.h"
#include "palpa/trace/trace.h"

namespace palpa {

namespace detail {

inline vtkSmartPointer<vtkDataArray> vtk_array(VoxelType type) {
  switch (type) {
    case VoxelType::uint8: return vtkSmartPointer<vtkUnsignedCharArray>::New();
    case VoxelType::int16: return vtkSmartPointer<vtkShortArray>::New();
    case VoxelType::uint16: return vtkSmartPointer<vtkUnsignedShortArray>::New();
    case VoxelType::int32: return vtkSmartPointer<vtkIntArray>::New();
    case VoxelType::float32: return vtkSmartPointer<vtkFloatArray>::New();
    case VoxelType::float64: return vtkSmartPointer<vtkDoubleArray>::New();
  }
  throw std::invalid_argument("the grid's type of voxel is unknown");
}

/// Sets the geometry of an image without values; false if no VTK image has it (sheared, uneven).
inline bool place_image(const GridGeometry& grid, vtkImageData& image) {
  if (grid.is_rectilinear()) return false;
  const Mat3 steps = transposed(grid.index_to_world_m);
  Mat3 axes;
  double spacing_m[3];
  for (int a = 0; a < 3; ++a) {
    spacing_m[a] = norm(steps.row[a]);
    axes.row[a] = (1.0 / spacing_m[a]) * steps.row[a];
    if (grid.dims[static_cast<std::size_t>(a)] > std::numeric_limits<int>::max()) return false;
  }
  for (int a = 0; a < 3; ++a) {
    if (std::abs(dot(axes.row[a], axes.row[(a + 1) % 3])) > 1e-6) return false;
  }
  image.SetDimensions(static_cast<int>(grid.dims[0]), static_cast<int>(grid.dims[1]), static_cast<int>(grid.dims[2]));
  image.SetSpacing(spacing_m);
  image.SetOrigin(grid.origin_m.x, grid.origin_m.y, grid.origin_m.z);
  const Mat3 d = transposed(axes);
  image.SetDirectionMatrix(d.row[0].x, d.row[0].y, d.row[0].z, d.row[1].x, d.row[1].y, d.row[1].z, d.row[2].x, d.row[2].y,
                           d.row[2].z);
  return true;
}

/// The voxels, in their own type if they need no scale.
inline vtkSmartPointer<vtkDataArray> voxels_to_vtk(const GridView& grid, int components) {
  const std::int64_t count = grid.geometry.voxels() * components;
  vtkSmartPointer<vtkDataArray> values = vtk_array(grid.voxels.type);
  values->SetNumberOfComponents(components);
  values->SetNumberOfTuples(grid.geometry.voxels());
  std::memcpy(values->GetVoidPointer(0), grid.voxels.data.get(), static_cast<std::size_t>(count) * size_of(grid.voxels.type));
  if (grid.scale == 1.0 && grid.offset == 0.0) return values;
  vtkNew<vtkDoubleArray> scaled;
  scaled->SetNumberOfComponents(components);
  scaled->SetNumberOfTuples(grid.geometry.voxels());
  for (vtkIdType n = 0; n < grid.geometry.voxels(); ++n) {
    for (int c = 0; c < components; ++c) scaled->SetComponent(n, c, values->GetComponent(n, c) * grid.scale + grid.offset);
  }
  return scaled;
}

/// Places `image` on the field's box and samples it. Throws std::invalid_argument on fewer than two samples or an empty box.
inline vtkSmartPointer<vtkDataArray> samples_to_vtk(const Field& field, int samples, vtkImageData& image) {
  const int components = field.components();
  if (samples < 2) throw std::invalid_argument("an image needs two samples or more along its longest side");
  const Box box = field.bounds_m();
  const Vec3 size_m = box.size_m();
  const double sides_m[] = {size_m.x, size_m.y, size_m.z};
  const double step_m = std::max({size_m.x, size_m.y, size_m.z}) / (samples - 1);
  if (!(step_m > 0.0) || !std::isfinite(step_m)) throw std::invalid_argument("the field's box has no size to sample");
  int dims[3];
  double spacing_m[3];
  for (int a = 0; a < 3; ++a) {
    dims[a] = static_cast<int>(std::lround(sides_m[a] / step_m)) + 1;
    spacing_m[a] = dims[a] > 1 ? sides_m[a] / (dims[a] - 1) : step_m;
  }
  image.SetDimensions(dims);
  image.SetSpacing(spacing_m);
  image.SetOrigin(box.low_m.x, box.low_m.y, box.low_m.z);
  vtkNew<vtkFloatArray> sampled;
  sampled->SetNumberOfComponents(components);
  sampled->SetNumberOfTuples(image.GetNumberOfPoints());
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  for (vtkIdType n = 0; n < image.GetNumberOfPoints(); ++n) {
    const double* const p = image.GetPoint(n);
    const Vec3 at_m{std::clamp(p[0], box.low_m.x, box.high_m.x), std::clamp(p[1], box.low_m.y, box.high_m.y),
                    std::clamp(p[2], box.low_m.z, box.high_m.z)};
    if (components == 1) {
      const ScalarSample s = field.scalar(at_m);
      sampled->SetComponent(n, 0, s.inside ? s.value : none);
    } else {
      const VectorSample s = field.vector(at_m);
      const double parts[] = {s.value.x, s.value.y, s.value.z};
      for (int c = 0; c < 3; ++c) sampled->SetComponent(n, c, s.inside ? parts[c] : none);
    }
  }
  return sampled;
}

}  // namespace detail

/// Field as an image, with its values as scalars, or vectors. A grid keeps its voxels, in their own type if they need no scale
/// (interpolated by VTK, trilinear); a field without voxels, or with a geometry that no VTK image has, is sampled over its box,
/// NaN without data. Allocates: the values are a copy. Any thread.
/// \param samples  along the longest side, if sampled; >= 2
/// Throws std::invalid_argument, with a sentence, on fewer.
inline vtkSmartPointer<vtkImageData> to_vtk(const Field& field, const std::string& name = "value", int samples = 128) {
  auto image = vtkSmartPointer<vtkImageData>::New();
  const int components = field.components();
  const GridView* const grid = grid_behind(field);
  const bool of_voxels = grid && !grid->signless && detail::place_image(grid->geometry, *image);
  const vtkSmartPointer<vtkDataArray> values =
      of_voxels ? detail::voxels_to_vtk(*grid, components) : detail::samples_to_vtk(field, samples, *image);
  values->SetName(name.c_str());
  components == 1 ? image->GetPointData()->SetScalars(values) : image->GetPointData()->SetVectors(values);
  return image;
}

/// Felt path as a line through the proxy's positions [m] with a vertex at each, and every column as an array; the data of
/// `palpa export … .vtp`. Allocates; any thread.
inline vtkSmartPointer<vtkPolyData> to_vtk(const FeltPath& path) {
  auto line = vtkSmartPointer<vtkPolyData>::New();
  const auto ticks = static_cast<vtkIdType>(path.ticks());
  for (const FeltColumn& column : path.columns) {
    vtkSmartPointer<vtkDataArray> array;
    if (column.is_whole) {
      array = vtkSmartPointer<vtkLongLongArray>::New();
    } else {
      array = vtkSmartPointer<vtkDoubleArray>::New();
    }
    array->SetName(column.name.c_str());
    array->SetNumberOfComponents(column.components);
    array->SetNumberOfTuples(ticks);
    for (vtkIdType n = 0; n < ticks * column.components; ++n)
      array->SetComponent(n / column.components, static_cast<int>(n % column.components),
                          column.values[static_cast<std::size_t>(n)]);
    if (column.name == "proxy_m") {
      vtkNew<vtkPoints> points;
      points->SetData(array);
      line->SetPoints(points);
    } else {
      line->GetPointData()->AddArray(array);
    }
  }
  line->GetPointData()->SetActiveVectors("force_n");
  vtkNew<vtkCellArray> lines, vertices;
  lines->InsertNextCell(static_cast<int>(ticks));
  for (vtkIdType n = 0; n < ticks; ++n) lines->InsertCellPoint(n), vertices->InsertNextCell(1, &n);
  line->SetLines(lines);
  line->SetVerts(vertices);
  return line;
}

/// Transfer function as VTK's, to display strength as opacity. Steps become as steep as doubles allow. Allocates; any thread.
/// \param factor  [1/N] or [1] of the results: 1 / 5 N makes 5 N opaque
inline vtkSmartPointer<vtkPiecewiseFunction> to_vtk(const TransferFunction& curve, double factor = 1.0) {
  auto function = vtkSmartPointer<vtkPiecewiseFunction>::New();
  const auto& points = curve.points();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (points.empty()) return function;
  const double outside = curve.outside();
  const bool steps_begin = points.front().result != outside, steps_end = points.back().result != outside;
  if (steps_begin) function->AddPoint(std::nextafter(points.front().value, -infinity), factor * outside);
  for (std::size_t n = 0; n < points.size(); ++n) {
    // VTK has one point per value.
    const bool above_a_step = n > 0 && points[n].value == points[n - 1].value;
    function->AddPoint(above_a_step ? std::nextafter(points[n].value, infinity) : points[n].value, factor * points[n].result);
  }
  if (steps_end) {
    const double last = function->GetRange()[1];
    function->AddPoint(std::nextafter(last, infinity), factor * outside);
  }
  function->ClampingOn();
  return function;
}

/// VTK's function as a transfer function: straight pieces unchanged, bent pieces (midpoint, sharpness) as 32 straight pieces.
/// Beyond its points it is 0 without clamping; with clamping it is the result of its ends, which must be equal, as a transfer
/// function has only one.
/// Throws std::invalid_argument, with a sentence, on a function without points, on two different ends with clamping, and on
/// points that TransferFunction refuses. Allocates; any thread.
/// \param factor  [N] or [1] of VTK's values: 5 N for an opacity of 1
inline TransferFunction transfer_function_from_vtk(vtkPiecewiseFunction& function, double factor = 1.0) {
  constexpr int pieces = 32;  // of a bent piece. More: slower lookups; fewer: corners are felt
  const int count = function.GetSize();
  if (count == 0) throw std::invalid_argument("vtkPiecewiseFunction: has no points; add one");
  std::vector<TransferFunction::Point> points;
  double before[4] = {};
  for (int n = 0; n < count; ++n) {
    double node[4];  // value, result, midpoint and sharpness of the following piece
    function.GetNodeValue(n, node);
    if (n > 0 && (before[2] != 0.5 || before[3] != 0.0)) {
      for (int i = 1; i < pieces; ++i) {
        const double value = before[0] + (node[0] - before[0]) * i / pieces;
        points.push_back({value, factor * function.GetValue(value)});
      }
    }
    points.push_back({node[0], factor * node[1]});
    std::copy(node, node + 4, before);
  }
  double outside = 0.0;
  if (function.GetClamping() != 0) {
    if (points.front().result != points.back().result) {
      throw std::invalid_argument("vtkPiecewiseFunction: clamps to " + std::to_string(points.front().result) +
                                  " below and to " + std::to_string(points.back().result) +
                                  " above; a transfer function is one number beyond its points: turn clamping off, or make its "
                                  "ends alike");
    }
    outside = points.front().result;
  }
  return {std::move(points), outside};
}

}  // namespace palpa
