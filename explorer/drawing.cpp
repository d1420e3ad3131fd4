#include "explorer/drawing.h"

#include <vtkActor.h>
#include <vtkGPUVolumeRayCastMapper.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProp.h>
#include <vtkPropCollection.h>
#include <vtkProperty.h>
#include <vtkQuadricClustering.h>
#include <vtkQuadricDecimation.h>
#include <vtkRenderer.h>
#include <vtkScalarsToColors.h>
#include <vtkTriangleFilter.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "palpa/data/parallel.h"
#include "palpa/view/offscreen.h"
#include "palpa/view/scene_shapes.h"
#include "palpa/view/shapes.h"

namespace palpa::explorer {
namespace {

// [triangles] that software rendering on two cores draws 25 times a second. More: a drag stutters; fewer: edges show.
constexpr double coarse_triangles = 8e3;
// [1] Samples along the longest side of a preview, its streamlines, and kept points of streamlines.
constexpr int rough_samples = 56, rough_lines = 16;
constexpr vtkIdType most_stream_points = 20'000;

vtkPolyData* surface_of(vtkProp* prop) {
  auto* actor = vtkActor::SafeDownCast(prop);
  if (!actor || !actor->GetMapper()) return nullptr;
  actor->GetMapper()->Update();
  return vtkPolyData::SafeDownCast(actor->GetMapper()->GetInput());
}

/// Smooth surface with about `share` of the triangles.
vtkSmartPointer<vtkPolyData> coarser(vtkPolyData* surface, double share) {
  // Cells of the clustering grid: a closed surface keeps about eight triangles per column of cells.
  double bounds[6];
  surface->GetBounds(bounds);
  const double longest = std::max({bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4], 1e-12});
  // First clustering on a fine grid, which is fast, then decimation by error, which keeps thin walls whole.
  constexpr double finer = 5.0;
  const double along = std::sqrt(std::min(1.0, finer * share) * static_cast<double>(surface->GetNumberOfPolys()) / 8.0);
  const auto cells = [&](int axis) {
    return std::max(2, static_cast<int>(along * (bounds[2 * axis + 1] - bounds[2 * axis]) / longest));
  };
  vtkNew<vtkPolyData> bare;
  bare->SetPoints(surface->GetPoints());
  bare->SetPolys(surface->GetPolys());
  bare->GetPointData()->SetScalars(surface->GetPointData()->GetScalars());
  vtkNew<vtkTriangleFilter> triangles;
  triangles->SetInputData(bare);
  vtkNew<vtkQuadricClustering> clusters;
  clusters->SetInputConnection(triangles->GetOutputPort());
  clusters->AutoAdjustNumberOfDivisionsOff();
  clusters->SetNumberOfDivisions(cells(0), cells(1), cells(2));
  clusters->UseInputPointsOn();
  clusters->CopyCellDataOff();
  vtkNew<vtkPolyDataNormals> normals;
  clusters->Update();
  const double kept = static_cast<double>(clusters->GetOutput()->GetNumberOfPolys());
  vtkNew<vtkQuadricDecimation> fewer;
  fewer->SetInputConnection(clusters->GetOutputPort());
  fewer->SetTargetReduction(
      std::clamp(1.0 - share * static_cast<double>(surface->GetNumberOfPolys()) / std::max(kept, 1.0), 0.0, 0.99));
  normals->SetInputConnection(fewer->GetOutputPort());
  normals->SplittingOff();
  normals->ConsistencyOff();
  normals->Update();
  return normals->GetOutput();
}

/// Coarser surfaces, on all cores; empty for a share of 1 or more.
std::map<vtkPolyData*, vtkSmartPointer<vtkPolyData>> coarser_of(const std::set<vtkPolyData*>& surfaces, double share) {
  std::map<vtkPolyData*, vtkSmartPointer<vtkPolyData>> coarse;
  if (share >= 1.0) return coarse;
  std::vector<vtkSmartPointer<vtkPolyData>*> made;
  for (vtkPolyData* surface : surfaces) made.push_back(&coarse[surface]);
  const std::vector<vtkPolyData*> fine(surfaces.begin(), surfaces.end());
  detail::in_parts(static_cast<std::int64_t>(fine.size()), 1, [&](std::int64_t first, std::int64_t last) {
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) *made[i] = coarser(fine[i], share);
  });
  return coarse;
}

/// Actor for `surface` with the settings of another actor: vertex colours if that is visible, depth only if not.
vtkSmartPointer<vtkActor> in_place_of(vtkActor& actor, vtkPolyData* surface) {
  auto copy = vtkSmartPointer<vtkActor>::New();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(surface);
  mapper->SetScalarVisibility(actor.GetProperty()->GetOpacity() > 0.0);
  copy->SetMapper(mapper);
  copy->GetProperty()->DeepCopy(actor.GetProperty());
  copy->GetProperty()->LightingOff();
  if (actor.GetForceOpaque()) copy->ForceOpaqueOn();
  return copy;
}

/// Vertex colours as the actor's mapper computes them.
vtkSmartPointer<vtkUnsignedCharArray> colors_of(vtkActor& actor, vtkPolyData* surface) {
  auto colors = vtkSmartPointer<vtkUnsignedCharArray>::New();
  vtkMapper& mapper = *actor.GetMapper();
  vtkDataArray* values = mapper.GetScalarVisibility() ? surface->GetPointData()->GetScalars() : nullptr;
  if (values) {
    vtkScalarsToColors& map = *mapper.GetLookupTable();
    const auto mapped = vtkSmartPointer<vtkUnsignedCharArray>::Take(map.MapScalars(values, mapper.GetColorMode(), -1));
    colors->DeepCopy(mapped);
    return colors;
  }
  double own[3];
  actor.GetProperty()->GetColor(own);
  colors->SetNumberOfComponents(4);
  colors->SetNumberOfTuples(surface->GetNumberOfPoints());
  for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i)
    colors->SetTuple4(i, 255.0 * own[0], 255.0 * own[1], 255.0 * own[2], 255.0);
  return colors;
}

/// Layers except slices, and their indices in the scene's.
std::vector<ViewLayer> drawn_layers(const Scene& scene, std::vector<std::size_t>& numbers) {
  std::vector<ViewLayer> drawn;
  const std::vector<ViewLayer> layers = detail::layers_of(scene);
  for (std::size_t number = 0; number < layers.size(); ++number) {
    if (layers[number].show == ViewLayer::Show::slices) continue;
    drawn.push_back(layers[number]);
    numbers.push_back(number);
  }
  return drawn;
}

void add_points(vtkProp* prop, std::vector<Vec3>& points_m) {
  vtkPolyData* const tubes = surface_of(prop);
  if (!tubes || !tubes->GetPoints()) return;
  const vtkIdType count = tubes->GetNumberOfPoints(), stride = count / most_stream_points + 1;
  for (vtkIdType i = 0; i < count; i += stride) {
    double p[3];
    tubes->GetPoint(i, p);
    points_m.push_back({p[0], p[1], p[2]});
  }
}

/// A cloud's layer: clouds have no entry in `LayerSigns::actors`, and are drawn from the last layer to the first.
std::size_t layer_of_cloud(const std::vector<ViewLayer>& layers, std::size_t cloud) {
  for (std::size_t number = layers.size(); number-- > 0;)
    if (layers[number].show == ViewLayer::Show::volume && cloud-- == 0) return number;
  return 0;
}

template <class Visit>
void visit_props(vtkRenderer& renderer, const Visit& visit) {
  vtkPropCollection& props = *renderer.GetViewProps();
  props.InitTraversal();
  while (vtkProp* prop = props.GetNextProp()) visit(prop);
}

void shade(vtkVolume& cloud) {
  // Shading shows the shape; a still picture shows it by colours alone.
  vtkVolumeProperty& look = *cloud.GetProperty();
  look.ShadeOn();
  look.SetAmbient(0.3);
  look.SetDiffuse(0.8);
  look.SetSpecular(0.15);
  look.SetSpecularPower(20.0);
  // Sampling steps would show as rings.
  if (auto* mapper = vtkGPUVolumeRayCastMapper::SafeDownCast(cloud.GetMapper())) mapper->UseJitteringOn();
}

/// The shell of `fine`, drawn by the surface that is made of it; none if it is no shell.
std::optional<detail::Shell> shell_of(vtkPolyData* fine, vtkPolyData* made, const std::vector<detail::Shell>& shells) {
  for (const detail::Shell& shell : shells) {
    if (shell.surface == fine) return detail::Shell{made, shell.color, shell.opacity};
  }
  return {};
}

}  // namespace

void CoarseSurface::light(const Vec3& right, const Vec3& up, const Vec3& towards) {
  vtkPointData& points = *surface->GetPointData();
  if (shell) {
    detail::shade(*shell, towards);
    own = vtkUnsignedCharArray::SafeDownCast(points.GetScalars());
  }
  vtkDataArray& normals = *points.GetNormals();
  const bool lit = look->GetLighting();
  const double without = lit ? look->GetAmbient() : 1.0;
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(4);
  colors->SetNumberOfTuples(own->GetNumberOfTuples());
  for (vtkIdType i = 0; i < own->GetNumberOfTuples(); ++i) {
    double n[3], color[4];
    normals.GetTuple(i, n);
    own->GetTuple(i, color);
    const Vec3 normal{n[0], n[1], n[2]};
    const detail::Light light =
        lit ? detail::light_on({dot(normal, right), dot(normal, up), dot(normal, towards)}, look->GetSpecularPower())
            : detail::Light{};
    for (int c = 0; c < 3; ++c)
      color[c] = std::min(255.0, (without + look->GetDiffuse() * light.diffuse) * color[c] +
                                     255.0 * look->GetSpecular() * light.specular * look->GetSpecularColor()[c]);
    colors->SetTuple(i, color);
  }
  points.SetScalars(colors);
}

Drawing draw_for_window(const Scene& scene, const Vec3& towards, bool rough) {
  detail::QuietVtk quiet;
  std::vector<std::size_t> numbers;  // of the layers that are drawn
  const std::vector<ViewLayer> layers = drawn_layers(scene, numbers);
  Drawing drawing;
  drawing.is_rough = rough;
  drawing.bounds_m = detail::worth_showing(scene, {});
  const Vec3 size = drawing.bounds_m.size_m();
  vtkNew<vtkRenderer> solid, shells;
  detail::LayerOptions options{drawing.bounds_m, true, scene.time().at(0.0), 0.6 * largest_component(size), towards};
  if (rough) options.most_samples = rough_samples, options.most_lines = rough_lines;
  drawing.signs = detail::draw_layers(solid, shells, scene, layers, options);
  drawing.fine_shells = drawing.signs.shells;
  for (const detail::LayerActor& one : drawing.signs.actors)
    if (layers[one.layer].show == ViewLayer::Show::streamlines) add_points(one.actor, drawing.stream_points_m);

  double all = 0.0;
  std::set<vtkPolyData*> surfaces;  // a shell is drawn twice
  for (vtkRenderer* renderer : {solid.Get(), shells.Get()})
    visit_props(*renderer, [&](vtkProp* prop) {
      vtkPolyData* const surface = surface_of(prop);
      if (!surface || surface->GetNumberOfPolys() == 0) return;
      all += static_cast<double>(surface->GetNumberOfPolys());
      surfaces.insert(surface);
    });

  const auto coarse = coarser_of(surfaces, coarse_triangles / std::max(all, 1.0));
  const auto take = [&](vtkRenderer* renderer, std::vector<Drawing::Part>& parts) {
    visit_props(*renderer, [&](vtkProp* prop) {
      Drawing::Part part{.fine = prop, .coarse = {}, .layer = 0};
      for (const detail::LayerActor& one : drawing.signs.actors)
        if (one.actor == prop) part.layer = numbers[one.layer];
      if (auto* cloud = vtkVolume::SafeDownCast(prop)) {
        shade(*cloud);
        part.layer = numbers[layer_of_cloud(layers, drawing.clouds.size())];
        drawing.clouds.emplace_back(cloud);
      }
      vtkPolyData* const surface = surface_of(prop);
      if (surface) drawing.fine_triangles += static_cast<std::size_t>(surface->GetNumberOfPolys());
      if (const auto found = coarse.find(surface); found != coarse.end()) {
        const vtkSmartPointer<vtkPolyData>& made = found->second;
        vtkActor& actor = *vtkActor::SafeDownCast(prop);
        drawing.coarse_triangles += static_cast<std::size_t>(made->GetNumberOfPolys());
        part.coarse = in_place_of(actor, made);
        if (actor.GetProperty()->GetOpacity() > 0.0)
          drawing.coarse_surfaces.push_back(
              {made, colors_of(actor, made), shell_of(surface, made, drawing.fine_shells), actor.GetProperty()});
      }
      parts.push_back(std::move(part));
    });
  };
  take(solid, drawing.solid);
  take(shells, drawing.shells);
  quiet.raise_error();
  return drawing;
}

}  // namespace palpa::explorer
