// The layers of a scene as triangles and lines, for others to draw: a report's page turns them.
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

/// A surface of triangles, or a bundle of lines, in the hand frame.
struct Shape {
  std::size_t layer = 0;           ///< number in the scene's layers (`layers_of`)
  std::string words;               ///< as in a picture's legend; empty: a colour bar explains it
  std::optional<std::size_t> bar;  ///< number in SceneShapes::bars of that colour bar
  Color color;                     ///< of all of it, where `colors` is empty
  double opacity = 1.0;
  std::vector<Vec3> points_m;
  std::vector<Vec3> normals;  ///< [1] outwards, one for each point of a surface; empty: none
  std::vector<Color> colors;  ///< one for each point, or empty
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> line_points;  ///< [points] in each line, one line after the other
};

struct SceneShapes {
  std::vector<Shape> shapes;
  std::vector<ColorBar> bars;
  bool has_cloud = false;  ///< a layer is drawn as a cloud, which has no shape
};

/// The scene's layers as `scene_picture` draws them, at the moment `at`; surfaces last, in the order of their layers.
/// \param near            hand frame: what is farther is left out
/// \param most_triangles  [triangles] of all surfaces together; larger ones are made coarser, > 0
/// Throws LoadError on a layer of the wrong kind of field. One thread at a time; a second waits.
SceneShapes scene_shapes(const Scene& scene, const Box& near, DataTime at, std::size_t most_triangles);

/// The box in the hand frame that is worth showing: of the scene's layers, the part around what was felt.
Box worth_showing(const Scene& scene, const std::vector<Vec3>& felt_m);

}  // namespace palpa::detail
