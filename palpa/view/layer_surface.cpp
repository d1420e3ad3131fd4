#include "palpa/view/layer_surface.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include "palpa/view/shapes.h"

namespace palpa::detail {
namespace {

/// [1] Smallest component kept, in triangles of the largest. More: limbs are lost; less: tables and remains are drawn.
constexpr double least_part = 0.3;

/// Numbers of all points or normals of a surface, three each.
std::span<float> numbers_of(vtkDataArray& array) {
  auto& floats = *vtkFloatArray::FastDownCast(&array);
  return {floats.GetPointer(0), static_cast<std::size_t>(floats.GetNumberOfValues())};
}

Vec3 vector_at(std::span<const float> numbers, vtkIdType i) {
  const float* const v = &numbers[static_cast<std::size_t>(3 * i)];
  return {v[0], v[1], v[2]};
}

void set_vector(std::span<float> numbers, std::size_t i, const Vec3& v) {
  std::ranges::transform(std::array{v.x, v.y, v.z}, &numbers[3 * i], [](double part) { return static_cast<float>(part); });
}

using Triangle = std::array<vtkIdType, 3>;

/// Triangles of a surface that has only these.
std::span<const Triangle> triangles_of(vtkCellArray& cells) {
  cells.ConvertTo64BitStorage();
  return {reinterpret_cast<const Triangle*>(cells.GetConnectivityArray64()->GetPointer(0)),
          static_cast<std::size_t>(cells.GetNumberOfCells())};
}

vtkSmartPointer<vtkPolyData> surface_with(vtkPoints* points, vtkDataArray* normals, const std::vector<Triangle>& triangles) {
  vtkNew<vtkTypeInt64Array> corners;
  corners->SetNumberOfValues(static_cast<vtkIdType>(3 * triangles.size()));
  std::ranges::copy(triangles, reinterpret_cast<Triangle*>(corners->GetPointer(0)));
  vtkNew<vtkCellArray> cells;
  cells->SetData(3, corners);
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->SetPoints(points);
  surface->SetPolys(cells);
  surface->GetPointData()->SetNormals(normals);
  return surface;
}

/// Smooths normals over adjacent triangles, a few times: gradients of a trilinear interpolant jump between cells, which would
/// show as rings.
void calm_normals(std::span<float> n, std::span<const Triangle> triangles) {
  std::vector<float> sum(n.size());
  for (int round = 0; round < 8; ++round) {
    std::fill(sum.begin(), sum.end(), 0.0F);
    for (const Triangle& corners : triangles) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        float all = 0.0F;
        for (const vtkIdType i : corners) all += n[static_cast<std::size_t>(3 * i) + axis];
        for (const vtkIdType i : corners) sum[static_cast<std::size_t>(3 * i) + axis] += all;
      }
    }
    for (std::size_t i = 0; i < n.size() / 3; ++i) {
      const Vec3 unit = normalized({sum[3 * i], sum[3 * i + 1], sum[3 * i + 2]});
      if (norm_squared(unit) > 0.0) set_vector(n, i, unit);
    }
  }
}

}  // namespace

vtkSmartPointer<vtkPolyData> surface_of(vtkImageData* image, const Field& field, double level) {
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(image);
  contour->SetValue(0, level);
  contour->ComputeNormalsOn();
  contour->ComputeScalarsOff();
  contour->Update();
  vtkPolyData& raw = *contour->GetOutput();
  if (raw.GetNumberOfPoints() == 0) return vtkSmartPointer<vtkPolyData>::New();

  const std::span<float> places_m = numbers_of(*raw.GetPoints()->GetData());
  vtkDataArray* const all_normals = raw.GetPointData()->GetNormals();
  const std::span<float> normals = numbers_of(*all_normals);
  std::vector<char> usable(places_m.size() / 3, 1);
  Vec3 middle;
  double used = 0.0;
  for (std::size_t i = 0; i < usable.size(); ++i) {
    const Vec3 p = vector_at(places_m, static_cast<vtkIdType>(i));
    usable[i] = is_finite(p);
    if (!is_finite(p)) {
      set_vector(places_m, i, {});
      set_vector(normals, i, {0.0, 0.0, 1.0});
      continue;
    }
    middle += p;
    used += 1.0;
    if (!is_finite(vector_at(normals, static_cast<vtkIdType>(i))))  // beside a position without data
      set_vector(normals, i, -normalized(field.scalar(p).gradient));
  }
  if (used == 0.0) return vtkSmartPointer<vtkPolyData>::New();
  middle = middle / used;

  std::vector<Triangle> triangles;
  double outward = 0.0;
  for (const Triangle& corners : triangles_of(*raw.GetPolys())) {
    if (!std::ranges::all_of(corners, [&](vtkIdType i) { return usable[static_cast<std::size_t>(i)]; })) continue;
    triangles.push_back(corners);
    const auto from_middle = [&](std::size_t k) { return vector_at(places_m, corners[k]) - middle; };
    outward += dot(from_middle(0), cross(from_middle(1), from_middle(2)));
  }
  calm_normals(normals, triangles);
  if (outward < 0.0) {
    for (Triangle& corners : triangles) std::ranges::reverse(corners);
    for (float& part : normals) part = -part;
  }
  return surface_with(raw.GetPoints(), all_normals, triangles);
}

vtkSmartPointer<vtkPolyData> large_parts(vtkPolyData* surface) {
  // Disjoint sets of points, each with the triangles of a part: in a tenth of the time of VTK's connectivity filter.
  const std::span<const Triangle> all = triangles_of(*surface->GetPolys());
  const auto points = static_cast<std::size_t>(surface->GetNumberOfPoints());
  std::vector<vtkIdType> parent(points), size(points, 0), kept(points, -1);
  std::iota(parent.begin(), parent.end(), vtkIdType{0});
  const auto root = [&](vtkIdType i) {
    for (vtkIdType above; (above = parent[static_cast<std::size_t>(i)]) != i; i = above)
      parent[static_cast<std::size_t>(i)] = parent[static_cast<std::size_t>(above)];
    return static_cast<std::size_t>(i);
  };
  for (const auto& [a, b, c] : all)
    for (const vtkIdType other : {b, c}) parent[root(other)] = static_cast<vtkIdType>(root(a));
  for (const Triangle& corners : all) ++size[root(corners[0])];
  const auto least = static_cast<vtkIdType>(std::ceil(least_part * static_cast<double>(std::ranges::max(size))));
  if (std::ranges::all_of(size, [&](vtkIdType one) { return one == 0 || one >= least; })) return surface;

  const std::span<float> places_m = numbers_of(*surface->GetPoints()->GetData());
  const std::span<float> normals = numbers_of(*surface->GetPointData()->GetNormals());
  vtkNew<vtkPoints> kept_places;
  vtkNew<vtkFloatArray> kept_normals;
  kept_normals->SetNumberOfComponents(3);
  std::vector<Triangle> triangles;
  for (Triangle corners : all) {
    if (size[root(corners[0])] < least) continue;
    for (vtkIdType& corner : corners) {
      vtkIdType& at = kept[static_cast<std::size_t>(corner)];
      if (at < 0) {
        at = kept_places->InsertNextPoint(&places_m[static_cast<std::size_t>(3 * corner)]);
        kept_normals->InsertNextTypedTuple(&normals[static_cast<std::size_t>(3 * corner)]);
      }
      corner = at;
    }
    triangles.push_back(corners);
  }
  return surface_with(kept_places, kept_normals, triangles);
}

vtkSmartPointer<vtkActor> actor_of(vtkPolyData* surface, const Color& color) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(surface);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  vtkProperty& property = *actor->GetProperty();
  property.SetColor(color.red, color.green, color.blue);
  property.SetAmbient(surface_ambient);
  property.SetDiffuse(1.0 - surface_ambient);
  property.SetSpecular(0.1);
  property.SetSpecularPower(30);
  return actor;
}

void draw_shell(vtkRenderer* renderer, const Shell& shell, const Vec3& towards) {
  if (!shell.surface->GetPointData()->GetNormals()) return;  // empty surface
  shade(shell, towards);
  // Two passes: first depth only, then colour, of which only the nearest part passes the depth test. Both must be "opaque":
  // only in that pass VTK draws actors in the order of their addition.
  for (const double seen : {0.0, 1.0}) {
    const vtkSmartPointer<vtkActor> actor = actor_of(shell.surface, shell.color);
    actor->GetProperty()->SetOpacity(seen);
    if (seen == 0.0) {
      // Lighting the invisible pass would double the cost.
      actor->GetProperty()->LightingOff();
      actor->GetMapper()->ScalarVisibilityOff();
    }
    actor->ForceOpaqueOn();
    renderer->AddActor(actor);
  }
}

void shade(const Shell& shell, const Vec3& towards) {
  vtkPointData& points = *shell.surface->GetPointData();
  vtkDataArray& normals = *points.GetNormals();
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(4);
  colors->SetNumberOfTuples(normals.GetNumberOfTuples());
  const double rim = std::max(rim_opacity, shell.opacity);
  for (vtkIdType i = 0; i < normals.GetNumberOfTuples(); ++i) {
    double n[3];
    normals.GetTuple(i, n);
    const double aside = 1.0 - std::min(std::abs(dot({n[0], n[1], n[2]}, towards)), 1.0);
    colors->SetTuple4(i, 255.0 * shell.color.red, 255.0 * shell.color.green, 255.0 * shell.color.blue,
                      255.0 * (shell.opacity + (rim - shell.opacity) * aside * aside * aside));
  }
  points.SetScalars(colors);
}

}  // namespace palpa::detail
