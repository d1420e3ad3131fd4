// Layers of a scene as triangles and lines, for other renderers: a report's interactive view.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "palpa/data/timed_field.h"
#include "palpa/scene/scene.h"
#include "palpa/view/canvas.h"

namespace palpa::detail {

/// Triangulated surface, or bundle of lines, in the hand frame.
struct Shape {
  std::size_t layer = 0;           ///< index in the scene's layers (`layers_of`)
  std::string words;               ///< as in a picture's legend; empty: has a colour bar
  std::optional<std::size_t> bar;  ///< index of its colour bar in SceneShapes::bars
  Color color;                     ///< of the whole shape, if `colors` is empty
  double opacity = 1.0;
  std::vector<Vec3> points_m;
  std::vector<Vec3> normals;  ///< [1] outward, per point of a surface; or empty
  std::vector<Color> colors;  ///< per point, or empty
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> line_points;  ///< [points] in each line, in order
};

struct SceneShapes {
  std::vector<Shape> shapes;
  std::vector<ColorBar> bars;
  bool has_cloud = false;  ///< a layer is a cloud, which has no shape
};

/// The scene's layers as `scene_picture` draws them, at time `at`; surfaces last, in the order of their layers.
/// \param near            hand frame: the rest is cut off
/// \param most_triangles  [triangles] of all surfaces together; above, they are simplified, > 0
/// Throws LoadError on a layer of the wrong kind of field. Any thread; while it draws, others that draw are blocked.
SceneShapes scene_shapes(const Scene& scene, const Box& near, DataTime at, std::size_t most_triangles);

/// Box to show, hand frame: the part of the scene's layers around the felt positions.
Box worth_showing(const Scene& scene, const std::vector<Vec3>& path_m);

}  // namespace palpa::detail
