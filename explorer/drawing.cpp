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
#include <vtkTriangleFilter.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "palpa/view/offscreen.h"
#include "palpa/view/scene_shapes.h"

namespace palpa::explorer {
namespace {

// [triangles] that a processor without a graphics card draws thirty times a second. More: a drag is not smooth; fewer: edges
// show.
constexpr double coarse_triangles = 24e3;

vtkPolyData* surface_of(vtkProp* prop) {
  auto* actor = vtkActor::SafeDownCast(prop);
  if (!actor || !actor->GetMapper()) return nullptr;
  actor->GetMapper()->Update();
  return vtkPolyData::SafeDownCast(actor->GetMapper()->GetInput());
}

/// The surface with about `share` of its triangles, smooth.
vtkSmartPointer<vtkPolyData> coarser(vtkPolyData* surface, double share) {
  // Cells of the grid that points fall together in: of a closed surface about eight triangles are left for each column of them.
  double bounds[6];
  surface->GetBounds(bounds);
  const double longest = std::max({bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4], 1e-12});
  // First by a fine grid, which is fast, then by what matters least, which keeps thin walls whole.
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

vtkSmartPointer<vtkActor> like(vtkActor& actor, vtkPolyData* surface) {
  auto copy = vtkSmartPointer<vtkActor>::New();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(surface);
  copy->SetMapper(mapper);
  copy->SetProperty(actor.GetProperty());
  if (actor.GetForceOpaque()) copy->ForceOpaqueOn();
  return copy;
}

}  // namespace

Drawing draw_for_window(const Scene& scene, const Vec3& towards) {
  detail::QuietVtk quiet;
  std::vector<ViewLayer> layers = detail::layers_of(scene);
  std::erase_if(layers, [](const ViewLayer& layer) { return layer.show == ViewLayer::Show::slices; });
  Drawing drawing;
  drawing.bounds_m = detail::worth_showing(scene, {});
  const Vec3 size = drawing.bounds_m.size_m();
  vtkNew<vtkRenderer> solid, shells;
  drawing.signs = detail::draw_layers(solid, shells, scene, layers,
                                      {drawing.bounds_m, true, scene.time.at(0.0), 0.6 * largest_component(size), towards});
  drawing.fine_shells = drawing.signs.shells;

  const auto each = [](vtkRenderer* renderer, const auto& what) {
    vtkPropCollection& props = *renderer->GetViewProps();
    props.InitTraversal();
    while (vtkProp* prop = props.GetNextProp()) what(prop);
  };
  double all = 0.0;
  for (vtkRenderer* renderer : {solid.Get(), shells.Get()})
    each(renderer, [&](vtkProp* prop) {
      if (vtkPolyData* surface = surface_of(prop)) all += static_cast<double>(surface->GetNumberOfPolys());
    });
  const double share = coarse_triangles / std::max(all, 1.0);

  std::map<vtkPolyData*, vtkSmartPointer<vtkPolyData>> coarse;  // a shell is drawn twice
  const auto take = [&](vtkRenderer* renderer, std::vector<Drawing::Part>& parts) {
    each(renderer, [&](vtkProp* prop) {
      Drawing::Part part{.fine = prop};
      if (auto* cloud = vtkVolume::SafeDownCast(prop)) {
        // Light shows its shape, which a still picture leaves to its colours.
        vtkVolumeProperty& look = *cloud->GetProperty();
        look.ShadeOn();
        look.SetAmbient(0.3);
        look.SetDiffuse(0.8);
        look.SetSpecular(0.15);
        look.SetSpecularPower(20.0);
        // Its steps would show as rings.
        if (auto* mapper = vtkGPUVolumeRayCastMapper::SafeDownCast(cloud->GetMapper())) mapper->UseJitteringOn();
        drawing.clouds.emplace_back(cloud);
      }
      vtkPolyData* const surface = surface_of(prop);
      if (surface) drawing.fine_triangles += static_cast<std::size_t>(surface->GetNumberOfPolys());
      if (surface && share < 1.0 && surface->GetNumberOfPolys() > 0) {
        vtkSmartPointer<vtkPolyData>& made = coarse[surface];
        if (!made) made = coarser(surface, share);
        drawing.coarse_triangles += static_cast<std::size_t>(made->GetNumberOfPolys());
        part.coarse = like(*vtkActor::SafeDownCast(prop), made);
      }
      parts.push_back(std::move(part));
    });
  };
  take(solid, drawing.solid);
  take(shells, drawing.shells);
  for (const detail::Shell& shell : drawing.fine_shells) {
    const auto made = coarse.find(shell.surface);
    if (made != coarse.end()) drawing.coarse_shells.push_back({made->second, shell.color, shell.opacity});
  }
  quiet.raise_error();
  return drawing;
}

}  // namespace palpa::explorer
