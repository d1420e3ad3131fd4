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
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "palpa/view/shapes.h"

namespace palpa::detail {
namespace {

/// [1] Smallest component kept, in triangles of the largest. More: limbs are lost; less: tables and remains are drawn.
constexpr double least_part = 0.3;

Vec3 point_of(vtkPoints& points, vtkIdType i) {
  double p[3];
  points.GetPoint(i, p);
  return {p[0], p[1], p[2]};
}

template <class Act>
void each_polygon(vtkPolyData& surface, const Act& act) {
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  for (vtkIdType cell = 0; cell < surface.GetPolys()->GetNumberOfCells(); ++cell) {
    surface.GetPolys()->GetCellAtId(cell, size, corners);
    act(size, corners);
  }
}

/// Smooths normals over adjacent triangles, a few times: gradients of a trilinear interpolant jump between cells, which would
/// show as rings.
void calm_normals(vtkPolyData& surface) {
  if (surface.GetNumberOfPolys() == 0) return;
  auto& normals = *vtkFloatArray::FastDownCast(surface.GetPointData()->GetNormals());
  auto* n = normals.GetPointer(0);
  const auto count = static_cast<std::size_t>(3 * normals.GetNumberOfTuples());
  std::vector<float> sum(count);
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  for (int round = 0; round < 8; ++round) {
    std::fill(sum.begin(), sum.end(), 0.0F);
    for (vtkIdType cell = 0; cell < surface.GetPolys()->GetNumberOfCells(); ++cell) {
      surface.GetPolys()->GetCellAtId(cell, size, corners);
      for (int axis = 0; axis < 3; ++axis) {
        float all = 0.0F;
        for (vtkIdType i = 0; i < size; ++i) all += n[3 * corners[i] + axis];
        for (vtkIdType i = 0; i < size; ++i) sum[static_cast<std::size_t>(3 * corners[i] + axis)] += all;
      }
    }
    for (std::size_t i = 0; i < count; i += 3) {
      const Vec3 unit = normalized({sum[i], sum[i + 1], sum[i + 2]});
      if (norm_squared(unit) == 0.0) continue;
      n[i] = static_cast<float>(unit.x);
      n[i + 1] = static_cast<float>(unit.y);
      n[i + 2] = static_cast<float>(unit.z);
    }
  }
}

void reverse(vtkPolyData& surface) {
  surface.BuildCells();
  for (vtkIdType cell = 0; cell < surface.GetNumberOfCells(); ++cell) surface.ReverseCell(cell);
  vtkDataArray& normals = *surface.GetPointData()->GetNormals();
  for (vtkIdType i = 0; i < normals.GetNumberOfTuples(); ++i) {
    double n[3];
    normals.GetTuple(i, n);
    normals.SetTuple3(i, -n[0], -n[1], -n[2]);
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
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  if (raw.GetNumberOfPoints() == 0) return surface;

  vtkPoints& points = *raw.GetPoints();
  vtkDataArray& normals = *raw.GetPointData()->GetNormals();
  const vtkIdType count = points.GetNumberOfPoints();
  std::vector<char> usable(static_cast<std::size_t>(count), 1);
  Vec3 middle;
  double used = 0.0;
  for (vtkIdType i = 0; i < count; ++i) {
    const Vec3 p = point_of(points, i);
    usable[static_cast<std::size_t>(i)] = is_finite(p);
    if (!is_finite(p)) {
      points.SetPoint(i, 0.0, 0.0, 0.0);
      normals.SetTuple3(i, 0.0, 0.0, 1.0);
      continue;
    }
    middle += p;
    used += 1.0;
    double n[3];
    normals.GetTuple(i, n);
    if (is_finite(Vec3{n[0], n[1], n[2]})) continue;
    const Vec3 down = -normalized(field.scalar(p).gradient);  // beside a position without data
    normals.SetTuple3(i, down.x, down.y, down.z);
  }
  if (used == 0.0) return surface;
  middle = middle / used;

  vtkNew<vtkCellArray> cells;
  double outward = 0.0;
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  for (vtkIdType cell = 0; cell < raw.GetPolys()->GetNumberOfCells(); ++cell) {
    raw.GetPolys()->GetCellAtId(cell, size, corners);
    if (!std::all_of(corners, corners + size, [&](vtkIdType i) { return usable[static_cast<std::size_t>(i)]; })) continue;
    cells->InsertNextCell(size, corners);
    const Vec3 a = point_of(points, corners[0]) - middle;
    const Vec3 b = point_of(points, corners[1]) - middle;
    const Vec3 c = point_of(points, corners[2]) - middle;
    outward += dot(a, cross(b, c));
  }
  surface->SetPoints(&points);
  surface->SetPolys(cells);
  surface->GetPointData()->SetNormals(&normals);
  calm_normals(*surface);
  if (outward < 0.0) reverse(*surface);
  return surface;
}

vtkSmartPointer<vtkPolyData> large_parts(vtkPolyData* surface) {
  // Disjoint sets of points, each with the triangles of a part: in a tenth of the time of VTK's connectivity filter.
  const vtkIdType points = surface->GetNumberOfPoints();
  std::vector<vtkIdType> parent(static_cast<std::size_t>(points)), size(parent.size(), 0), kept(parent.size(), -1);
  std::iota(parent.begin(), parent.end(), vtkIdType{0});
  const auto root = [&](vtkIdType i) {
    for (vtkIdType above; (above = parent[static_cast<std::size_t>(i)]) != i; i = above)
      parent[static_cast<std::size_t>(i)] = parent[static_cast<std::size_t>(above)];
    return static_cast<std::size_t>(i);
  };
  each_polygon(*surface, [&](vtkIdType corners, const vtkIdType* corner) {
    for (vtkIdType i = 1; i < corners; ++i) parent[root(corner[i])] = static_cast<vtkIdType>(root(corner[0]));
  });
  each_polygon(*surface, [&](vtkIdType, const vtkIdType* corner) { ++size[root(corner[0])]; });
  const auto least = static_cast<vtkIdType>(std::ceil(least_part * static_cast<double>(std::ranges::max(size))));
  if (std::ranges::all_of(size, [&](vtkIdType one) { return one == 0 || one >= least; })) return surface;

  vtkNew<vtkPoints> places;
  vtkNew<vtkFloatArray> normals;
  vtkNew<vtkCellArray> cells;
  normals->SetNumberOfComponents(3);
  each_polygon(*surface, [&](vtkIdType corners, const vtkIdType* corner) {
    if (size[root(corner[0])] < least) return;
    cells->InsertNextCell(static_cast<int>(corners));
    for (vtkIdType i = 0; i < corners; ++i) {
      vtkIdType& at = kept[static_cast<std::size_t>(corner[i])];
      if (at < 0) {
        at = places->InsertNextPoint(surface->GetPoint(corner[i]));
        normals->InsertNextTuple(surface->GetPointData()->GetNormals()->GetTuple(corner[i]));
      }
      cells->InsertCellPoint(at);
    }
  });
  auto large = vtkSmartPointer<vtkPolyData>::New();
  large->SetPoints(places);
  large->SetPolys(cells);
  large->GetPointData()->SetNormals(normals);
  return large;
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
