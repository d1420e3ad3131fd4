#include "palpa/view/scene_shapes.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTubeFilter.h>
#include <vtkVolumeCollection.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/data/parallel.h"
#include "palpa/view/layers.h"
#include "palpa/view/offscreen.h"
#include "palpa/view/simplified.h"
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

Vec3 point_of(vtkPolyData& data, vtkIdType i) {
  double p[3];
  data.GetPoint(i, p);
  return {p[0], p[1], p[2]};
}

/// Polygons are fans of triangles.
Mesh triangles_of(vtkPolyData& data) {
  Mesh mesh;
  for (vtkIdType i = 0; i < data.GetNumberOfPoints(); ++i) mesh.points_m.push_back(point_of(data, i));
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  for (vtkIdType cell = 0; cell < data.GetPolys()->GetNumberOfCells(); ++cell) {
    data.GetPolys()->GetCellAtId(cell, size, corners);
    const auto corner = [&](vtkIdType i) { return static_cast<std::uint32_t>(corners[i]); };
    for (vtkIdType i = 2; i < size; ++i) mesh.triangles.push_back({corner(0), corner(i - 1), corner(i)});
  }
  return mesh;
}

Vec3 vector_at(vtkDataArray& array, vtkIdType i) {
  return {array.GetComponent(i, 0), array.GetComponent(i, 1), array.GetComponent(i, 2)};
}

/// Adds a point with the normal and, if they are seen from everywhere, the colour of point `like` of the data.
void add_point(const Vec3& place_m, vtkPolyData& data, vtkIdType like, bool with_color, Shape& shape) {
  shape.points_m.push_back(place_m);
  if (vtkDataArray* normals = data.GetPointData()->GetNormals()) shape.normals.push_back(vector_at(*normals, like));
  if (vtkDataArray* colors = data.GetPointData()->GetScalars(); with_color && colors && colors->GetNumberOfComponents() >= 3) {
    const Vec3 bytes = vector_at(*colors, like);
    shape.colors.push_back({bytes.x / 255.0, bytes.y / 255.0, bytes.z / 255.0});
  }
}

void add_lines(vtkPolyData& data, Shape& shape) {
  vtkIdType size = 0;
  const vtkIdType* points = nullptr;
  for (vtkIdType line = 0; line < data.GetLines()->GetNumberOfCells(); ++line) {
    data.GetLines()->GetCellAtId(line, size, points);
    for (vtkIdType i = 0; i < size; ++i) add_point(point_of(data, points[i]), data, points[i], true, shape);
    shape.line_points.push_back(static_cast<std::uint32_t>(size));
  }
}

/// Surface of a layer, drawn and as triangles.
struct Surface {
  vtkPolyData* drawn;  // a shell is drawn twice
  Mesh triangles;
  Shape shape;
  bool is_level;
};

void add_triangles(const Surface& surface, const SimplerMesh& mesh, Shape& shape) {
  for (std::size_t i = 0; i < mesh.points_m.size(); ++i)  // a shell's colours are opacities for one viewpoint
    add_point(mesh.points_m[i], *surface.drawn, mesh.like[i], !surface.is_level, shape);
  shape.triangles = mesh.triangles;
}

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
    surfaces.push_back({data, triangles_of(*data), std::move(shape), drawn.style.has_value()});
    all += surfaces.back().triangles.triangles.size();
  }
  const double share = std::min(1.0, static_cast<double>(most_triangles) / std::max(1.0, static_cast<double>(all)));
  std::stable_sort(surfaces.begin(), surfaces.end(), [](const Surface& a, const Surface& b) {
    return std::pair(a.is_level, a.shape.layer) < std::pair(b.is_level, b.shape.layer);
  });
  std::vector<SimplerMesh> simple(surfaces.size());
  in_parts(static_cast<std::int64_t>(surfaces.size()), 1, [&](std::int64_t first, std::int64_t last) {
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
      const Mesh& mesh = surfaces[i].triangles;
      simple[i] = simplified(mesh, static_cast<std::size_t>(std::ceil(share * static_cast<double>(mesh.triangles.size()))));
    }
  });
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    add_triangles(surfaces[i], simple[i], surfaces[i].shape);
    shapes.shapes.push_back(std::move(surfaces[i].shape));
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
