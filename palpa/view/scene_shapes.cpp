#include "palpa/view/scene_shapes.h"

#include <meshoptimizer.h>
#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkTubeFilter.h>
#include <vtkVolumeCollection.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <type_traits>
#include <utility>

#include "palpa/data/parallel.h"
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

Vec3 vector_at(vtkDataArray& array, vtkIdType i) {
  return {array.GetComponent(i, 0), array.GetComponent(i, 1), array.GetComponent(i, 2)};
}

/// Adds a point with its normal and, if the colours are those of any viewpoint, its colour.
void add_point(vtkPolyData& data, vtkIdType i, bool with_color, Shape& shape) {
  double p[3];
  data.GetPoint(i, p);
  shape.points_m.push_back({p[0], p[1], p[2]});
  if (vtkDataArray* normals = data.GetPointData()->GetNormals()) shape.normals.push_back(vector_at(*normals, i));
  if (vtkDataArray* colors = data.GetPointData()->GetScalars(); with_color && colors && colors->GetNumberOfComponents() >= 3) {
    const Vec3 bytes = vector_at(*colors, i);
    shape.colors.push_back({bytes.x / 255.0, bytes.y / 255.0, bytes.z / 255.0});
  }
}

void add_lines(vtkPolyData& data, Shape& shape) {
  vtkIdType size = 0;
  const vtkIdType* points = nullptr;
  for (vtkIdType line = 0; line < data.GetLines()->GetNumberOfCells(); ++line) {
    data.GetLines()->GetCellAtId(line, size, points);
    for (vtkIdType i = 0; i < size; ++i) add_point(data, points[i], true, shape);
    shape.line_points.push_back(static_cast<std::uint32_t>(size));
  }
}

/// Polygons are fans of triangles.
void add_triangles(vtkPolyData& data, bool with_color, Shape& shape) {
  for (vtkIdType i = 0; i < data.GetNumberOfPoints(); ++i) add_point(data, i, with_color, shape);
  vtkIdType size = 0;
  const vtkIdType* corners = nullptr;
  for (vtkIdType cell = 0; cell < data.GetPolys()->GetNumberOfCells(); ++cell) {
    data.GetPolys()->GetCellAtId(cell, size, corners);
    const auto corner = [&](vtkIdType i) { return static_cast<std::uint32_t>(corners[i]); };
    for (vtkIdType i = 2; i < size; ++i) shape.triangles.push_back({corner(0), corner(i - 1), corner(i)});
  }
}

/// Simplifies a surface to about `most_triangles`; the points that stay are original ones. Points that no triangle has go.
void simplify(Shape& surface, std::size_t most_triangles) {
  std::vector<std::array<float, 3>> positions_m;
  for (const Vec3& p : surface.points_m)
    positions_m.push_back({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
  std::vector<std::array<std::uint32_t, 3>> kept(surface.triangles.size());
  constexpr float any_error = 1.0F;
  const std::size_t corners =
      meshopt_simplify(kept[0].data(), surface.triangles[0].data(), 3 * kept.size(), positions_m[0].data(), positions_m.size(),
                       sizeof(positions_m[0]), 3 * most_triangles, any_error, 0, nullptr);
  std::vector<std::uint32_t> numbers(positions_m.size());
  const std::size_t points = meshopt_optimizeVertexFetchRemap(numbers.data(), kept[0].data(), corners, numbers.size());
  kept.resize(corners / 3);
  const auto keep = [&](auto& all) {
    if (all.empty()) return;
    std::remove_reference_t<decltype(all)> of_kept(points);
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (numbers[i] < points) of_kept[numbers[i]] = all[i];
    all = std::move(of_kept);
  };
  keep(surface.points_m);
  keep(surface.normals);
  keep(surface.colors);
  for (auto& triangle : kept)
    for (std::uint32_t& corner : triangle) corner = numbers[corner];
  surface.triangles = std::move(kept);
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

/// The layers as they are drawn; surfaces last.
SceneShapes drawn_shapes(const Scene& scene, const Box& near, DataTime at) {
  QuietVtk quiet;
  vtkNew<vtkRenderer> solid, shells;
  const std::vector<ViewLayer> layers = layers_of(scene);
  LayerOptions options{near, true, at, 0.5 * largest_component(near.size_m()), {0, 0, 1}};
  options.most_samples = most_samples;
  LayerSigns signs = draw_layers(solid, shells, scene, layers, options);
  SceneShapes shapes;
  shapes.bars = std::move(signs.bars);
  shapes.has_cloud = solid->GetVolumes()->GetNumberOfItems() > 0;

  std::vector<std::pair<bool, Shape>> surfaces;  // whether of a level
  std::set<vtkPolyData*> known;                  // a shell is drawn twice
  for (const LayerActor& drawn : signs.actors) {
    bool lines = false;
    vtkPolyData* const data = data_of(*drawn.actor, lines);
    if (!data || data->GetNumberOfPoints() == 0) continue;
    if (lines) {
      add_lines(*data, shapes.shapes.emplace_back(shape_of(drawn)));
    } else if (known.insert(data).second) {
      // Colours of a shell are opacities for one viewpoint.
      add_triangles(*data, !drawn.style, surfaces.emplace_back(drawn.style.has_value(), shape_of(drawn)).second);
    }
  }
  std::ranges::stable_sort(surfaces, {}, [](const auto& one) { return std::pair(one.first, one.second.layer); });
  for (auto& [is_level, surface] : surfaces) shapes.shapes.push_back(std::move(surface));
  quiet.raise_error();
  return shapes;
}

}  // namespace

SceneShapes scene_shapes(const Scene& scene, const Box& near, DataTime at, std::size_t most_triangles) {
  SceneShapes shapes = drawn_shapes(scene, near, at);
  double all = 0.0;
  for (const Shape& shape : shapes.shapes) all += static_cast<double>(shape.triangles.size());
  const double share = std::min(1.0, static_cast<double>(most_triangles) / std::max(1.0, all));
  in_parts(static_cast<std::int64_t>(shapes.shapes.size()), 1, [&](std::int64_t first, std::int64_t last) {
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
      Shape& shape = shapes.shapes[i];
      if (shape.triangles.empty()) continue;  // lines
      simplify(shape, static_cast<std::size_t>(std::ceil(share * static_cast<double>(shape.triangles.size()))));
    }
  });
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
