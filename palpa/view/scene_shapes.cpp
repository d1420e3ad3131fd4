#include "palpa/view/scene_shapes.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkQuadricDecimation.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkStaticPointLocator.h>
#include <vtkTriangleFilter.h>
#include <vtkTubeFilter.h>
#include <vtkVolumeCollection.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "palpa/view/layers.h"
#include "palpa/view/offscreen.h"
#include "palpa/view/streamlines.h"

namespace palpa::detail {
namespace {

// Smallest extent assumed for a path, as in scene_picture.cpp.
constexpr double least_felt_m = 0.02;

// Along the longest edge: more triangles than that would only be taken away again.
constexpr int most_samples = 120;

/// Data of an actor: the lines inside its tubes, or its surface.
vtkPolyData* data_of(vtkActor& actor, bool& lines) {
  if (auto* tubes = vtkTubeFilter::SafeDownCast(actor.GetMapper()->GetInputAlgorithm())) {
    tubes->Update();
    lines = true;
    return vtkPolyData::SafeDownCast(tubes->GetInput());
  }
  actor.GetMapper()->Update();
  return vtkPolyData::SafeDownCast(actor.GetMapper()->GetInput());
}

vtkSmartPointer<vtkPolyData> triangles_of(vtkPolyData* data) {
  vtkNew<vtkTriangleFilter> triangles;
  triangles->SetInputData(data);
  triangles->PassVertsOff();
  triangles->PassLinesOff();
  triangles->Update();
  return triangles->GetOutput();
}

/// Surface with about `share` of the triangles.
vtkSmartPointer<vtkPolyData> coarser(vtkPolyData* surface, double share) {
  vtkNew<vtkPolyData> bare;  // normals and colours are taken from the fine surface later
  bare->SetPoints(surface->GetPoints());
  bare->SetPolys(surface->GetPolys());
  vtkNew<vtkQuadricDecimation> decimation;
  decimation->SetInputData(bare);
  decimation->SetTargetReduction(1.0 - share);
  decimation->Update();
  return decimation->GetOutput();
}

Vec3 vector_at(vtkDataArray& array, vtkIdType i) {
  return {array.GetComponent(i, 0), array.GetComponent(i, 1), array.GetComponent(i, 2)};
}

/// Copies the points that cells use, with normals and colours of the nearest point of `fine`.
class PointCopy {
 public:
  PointCopy(vtkPolyData& from, vtkPolyData& fine, Shape& to) : from_(from), fine_(fine), to_(to) {
    if (&from != &fine) {
      locator_->SetDataSet(&fine);
      locator_->BuildLocator();
    }
  }
  std::uint32_t number_of(vtkIdType i) {
    const auto [known, fresh] = numbers_.try_emplace(i, static_cast<std::uint32_t>(to_.points_m.size()));
    if (!fresh) return known->second;
    double p[3];
    from_.GetPoint(i, p);
    to_.points_m.push_back({p[0], p[1], p[2]});
    const vtkIdType like = &from_ == &fine_ ? i : locator_->FindClosestPoint(p);
    if (vtkDataArray* normals = fine_.GetPointData()->GetNormals()) to_.normals.push_back(vector_at(*normals, like));
    if (vtkDataArray* colors = fine_.GetPointData()->GetScalars(); colors && colors->GetNumberOfComponents() >= 3) {
      const Vec3 bytes = vector_at(*colors, like);
      to_.colors.push_back({bytes.x / 255.0, bytes.y / 255.0, bytes.z / 255.0});
    }
    return known->second;
  }

 private:
  vtkPolyData& from_;
  vtkPolyData& fine_;
  Shape& to_;
  std::map<vtkIdType, std::uint32_t> numbers_;
  vtkNew<vtkStaticPointLocator> locator_;
};

void add_lines(vtkPolyData& data, Shape& shape) {
  PointCopy copy(data, data, shape);
  vtkIdType size = 0;
  const vtkIdType* points = nullptr;
  for (vtkIdType line = 0; line < data.GetLines()->GetNumberOfCells(); ++line) {
    data.GetLines()->GetCellAtId(line, size, points);
    for (vtkIdType i = 0; i < size; ++i) copy.number_of(points[i]);
    shape.line_points.push_back(static_cast<std::uint32_t>(size));
  }
}

void add_triangles(vtkPolyData& data, vtkPolyData& fine, Shape& shape) {
  PointCopy copy(data, fine, shape);
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  for (vtkIdType cell = 0; cell < data.GetPolys()->GetNumberOfCells(); ++cell) {
    data.GetPolys()->GetCellAtId(cell, size, corners);
    if (size == 3)
      shape.triangles.push_back({copy.number_of(corners[0]), copy.number_of(corners[1]), copy.number_of(corners[2])});
  }
}

/// Surface of a layer, drawn and as triangles.
struct Surface {
  vtkPolyData* drawn;  // a shell is drawn twice
  vtkSmartPointer<vtkPolyData> triangles;
  Shape shape;
  bool is_level;
};

/// Shape without points, with its layer's attributes.
Shape shape_of(const LayerActor& drawn) {
  Shape shape{.layer = drawn.layer, .words = drawn.words, .bar = drawn.bar, .color = {}};
  if (drawn.style) {
    shape.color = drawn.style->color;
    shape.opacity = drawn.style->opacity;
  } else {
    const double* rgb = drawn.actor->GetProperty()->GetColor();
    shape.color = {rgb[0], rgb[1], rgb[2]};
  }
  return shape;
}

}  // namespace

SceneShapes scene_shapes(const Scene& scene, const Box& near, DataTime at, std::size_t most_triangles) {
  QuietVtk quiet;
  vtkNew<vtkRenderer> solid, shells;
  const std::vector<ViewLayer> layers = layers_of(scene);
  LayerOptions options{near, true, at, 0.5 * largest_component(near.size_m()), {0, 0, 1}};
  options.most_samples = most_samples;
  LayerSigns signs = draw_layers(solid, shells, scene, layers, options);
  SceneShapes shapes;
  shapes.bars = std::move(signs.bars);
  shapes.has_cloud = solid->GetVolumes()->GetNumberOfItems() > 0;

  std::vector<Surface> surfaces;
  std::size_t all = 0;
  for (const LayerActor& drawn : signs.actors) {
    bool lines = false;
    vtkPolyData* const data = data_of(*drawn.actor, lines);
    if (!data || data->GetNumberOfPoints() == 0) continue;
    if (std::any_of(surfaces.begin(), surfaces.end(), [&](const Surface& s) { return s.drawn == data; })) continue;
    Shape shape = shape_of(drawn);
    if (lines) {
      add_lines(*data, shape);
      shapes.shapes.push_back(std::move(shape));
      continue;
    }
    surfaces.push_back({data, triangles_of(data), std::move(shape), drawn.style.has_value()});
    if (drawn.style)  // a shell's scalars are opacities for one viewpoint
      surfaces.back().triangles->GetPointData()->SetScalars(nullptr);
    all += static_cast<std::size_t>(surfaces.back().triangles->GetNumberOfPolys());
  }
  const double share = std::min(1.0, static_cast<double>(most_triangles) / std::max(1.0, static_cast<double>(all)));
  std::stable_sort(surfaces.begin(), surfaces.end(), [](const Surface& a, const Surface& b) {
    return std::pair(a.is_level, a.shape.layer) < std::pair(b.is_level, b.shape.layer);
  });
  for (Surface& surface : surfaces) {
    const vtkSmartPointer<vtkPolyData> used = share < 1.0 ? coarser(surface.triangles, share) : surface.triangles;
    add_triangles(*used, *surface.triangles, surface.shape);
    shapes.shapes.push_back(std::move(surface.shape));
  }
  quiet.raise_error();
  return shapes;
}

Box worth_showing(const Scene& scene, const std::vector<Vec3>& path_m) {
  const auto join = [](Box& box, const Vec3& p) {
    box.low_m = {std::min(box.low_m.x, p.x), std::min(box.low_m.y, p.y), std::min(box.low_m.z, p.z)};
    box.high_m = {std::max(box.high_m.x, p.x), std::max(box.high_m.y, p.y), std::max(box.high_m.z, p.z)};
  };
  constexpr double far = 1e300;
  Box data{{far, far, far}, {-far, -far, -far}};
  const Similarity map = scene.hand_to_world();
  for (const ViewLayer& layer : layers_of(scene)) {
    const Box box = in_hand_frame(scene.field(layer.field).field, map)->bounds_m();
    join(data, box.low_m);
    join(data, box.high_m);
  }
  if (path_m.empty()) return data;
  Box felt{path_m.front(), path_m.front()};
  for (const Vec3& p : path_m) join(felt, p);
  const double reach_m = 6.0 * std::max(largest_component(felt.size_m()), 2.0 * least_felt_m);
  const Vec3 reach{reach_m, reach_m, reach_m};
  return shared_part(data, {felt.centre_m() - reach, felt.centre_m() + reach});
}

}  // namespace palpa::detail
