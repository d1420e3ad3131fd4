// Shapes of a report's interactive page: true to the field at any resolution.
#include "palpa/view/scene_shapes.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"

namespace palpa::detail {
namespace scene_shapes_test {

/// No hole: each edge has as many triangles at either side. No point without a triangle.
void expect_closed(const Shape& shape) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  std::set<std::uint32_t> used;
  for (const auto& corners : shape.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      ++edges[{corners[k], corners[(k + 1) % 3]}];
      used.insert(corners[k]);
    }
  for (const auto& [edge, count] : edges) EXPECT_EQ((edges[{edge.second, edge.first}]), count);
  EXPECT_EQ(used.size(), shape.points_m.size());
}

TEST(SceneShapes, ABallIsABallInFewTriangles) {
  constexpr double radius_m = 0.05;
  Scene scene;
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  const FieldRef field = scene.add("ball", sphere_field(radius_m));
  scene.add("surface", SurfaceAndFriction{.field = field, .levels = {{.name = "skin", .value = 0.0, .strength_n = 1.0}}});
  for (const std::size_t most : {std::size_t{2000}, std::size_t{20'000}}) {
    const SceneShapes shapes = scene_shapes(scene, worth_showing(scene, {}), {}, most);
    ASSERT_EQ(shapes.shapes.size(), 1u);
    const Shape& ball = shapes.shapes[0];
    EXPECT_EQ(ball.words, "skin");
    EXPECT_LE(ball.triangles.size(), most + most / 50);
    EXPECT_GT(ball.triangles.size(), most / 2);
    expect_closed(ball);
    ASSERT_EQ(ball.normals.size(), ball.points_m.size());
    // A triangle of a ball covered by this many lies at most deep by the square of half its side over twice the radius.
    const double deep_m = 4.0 * radius_m / static_cast<double>(ball.triangles.size());
    for (std::size_t i = 0; i < ball.points_m.size(); ++i) {
      EXPECT_NEAR(norm(ball.points_m[i]), radius_m, deep_m + 2e-5);
      EXPECT_GT(dot(ball.normals[i], normalized(ball.points_m[i])), 0.98);
    }
    double volume_m3 = 0.0;
    for (const auto& [a, b, c] : ball.triangles)
      volume_m3 += dot(ball.points_m[a], cross(ball.points_m[b], ball.points_m[c])) / 6.0;
    EXPECT_NEAR(volume_m3, 4.0 / 3.0 * 3.14159265 * radius_m * radius_m * radius_m, 0.01 * volume_m3);
  }
}

SceneShapes balls_of(const std::vector<ViewLayer>& layers) {
  Scene scene;
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  scene.add("ball", sphere_field(0.05));
  scene.layers = layers;
  return scene_shapes(scene, worth_showing(scene, {}), {}, 400'000);
}

ViewLayer ball_of(const std::string& name, double level_m, const std::string& color, double opacity) {
  ViewLayer layer{.show = ViewLayer::Show::surface, .field = {"ball"}, .level = level_m, .name = name};
  layer.colors = {{level_m - 1.0, color, opacity}, {level_m + 1.0, color, opacity}};
  return layer;
}

std::string random_color(std::mt19937& random) {
  static constexpr char digits[] = "0123456789abcdef";
  std::string color = "#";
  for (int n = 0; n < 6; ++n) color += digits[random() % 16];
  return color;
}

TEST(SceneShapes, ALayerIsKnownByItsNumberWhateverItsColor) {
  std::mt19937 random(45);
  std::vector<std::string> colors{"#e8b899", "#f4efe0", "#9ecae1", "#000000", "#ffffff", "#010203"};
  for (int n = 0; n < 16; ++n) colors.push_back(random_color(random));
  for (std::size_t n = 0; n + 1 < colors.size(); n += 2) {
    const SceneShapes shapes = balls_of({ball_of("skin", 0.0, colors[n], 0.35), ball_of("bone", 0.015, colors[n + 1], 1.0)});
    ASSERT_EQ(shapes.shapes.size(), 2u);
    for (std::size_t layer = 0; layer < 2; ++layer) {
      const Shape& shape = shapes.shapes[layer];
      EXPECT_EQ(shape.layer, layer);
      EXPECT_EQ(shape.words, layer == 0 ? "skin" : "bone") << colors[n + layer];
      EXPECT_NEAR(shape.opacity, layer == 0 ? 0.35 : 1.0, 1e-9) << colors[n + layer];
      EXPECT_TRUE(shape.colors.empty()) << "drawn without light";
      EXPECT_FALSE(shape.bar.has_value());
      ASSERT_FALSE(shape.points_m.empty());
      EXPECT_NEAR(norm(shape.points_m.front()), layer == 0 ? 0.05 : 0.035, 1e-3) << "the other layer's points";
    }
  }
}

TEST(SceneShapes, ManyLayersOfOneColorStayApart) {
  std::vector<ViewLayer> layers;
  for (int n = 0; n < 12; ++n)
    layers.push_back(ball_of("shell " + std::to_string(n), 0.003 * n, "#e8b899", n < 11 ? 0.1 + 0.05 * n : 1.0));
  const SceneShapes shapes = balls_of(layers);
  ASSERT_EQ(shapes.shapes.size(), layers.size());
  for (std::size_t n = 0; n < layers.size(); ++n) {
    EXPECT_EQ(shapes.shapes[n].layer, n);
    EXPECT_EQ(shapes.shapes[n].words, layers[n].name);
    EXPECT_NEAR(shapes.shapes[n].opacity, layers[n].colors.front().opacity, 1e-9);
    EXPECT_TRUE(shapes.shapes[n].colors.empty());
    EXPECT_NEAR(norm(shapes.shapes[n].points_m.front()), 0.05 - 0.003 * static_cast<double>(n), 1e-3);
  }
}

TEST(SceneShapes, ALayerThatIsNotThereShiftsNoOther) {
  const SceneShapes shapes = balls_of(
      {ball_of("nowhere", 7.0, "#123456", 0.5), ball_of("skin", 0.0, "#f4efe0", 0.35), ball_of("bone", 0.02, "#f4efe0", 1.0)});
  ASSERT_EQ(shapes.shapes.size(), 2u);
  EXPECT_EQ(shapes.shapes[0].words, "skin");
  EXPECT_EQ(shapes.shapes[1].words, "bone");
  EXPECT_EQ(shapes.shapes[0].layer, 1u);
}

TEST(SceneShapes, EachColoredLayerHasItsOwnBar) {
  Scene scene;
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  scene.add("flow", sampled(burgers_vortex(), 16));
  scene.add("ball", sampled(sphere_field(0.05), 24));
  scene.layers = {ball_of("skin", 0.0, "#e8b899", 0.3),
                  {.show = ViewLayer::Show::slices, .field = {"ball"}, .name = "depth"},
                  {.show = ViewLayer::Show::streamlines, .field = {"flow"}, .name = "stream"},
                  {.show = ViewLayer::Show::glyphs, .field = {"flow"}, .name = "arrows"}};
  const SceneShapes shapes = scene_shapes(scene, worth_showing(scene, {}), {}, 400'000);
  std::set<std::size_t> layers;
  for (const Shape& shape : shapes.shapes) {
    layers.insert(shape.layer);
    const ViewLayer& layer = scene.layers[shape.layer];
    if (layer.show == ViewLayer::Show::surface) {
      EXPECT_FALSE(shape.bar.has_value());
      continue;
    }
    ASSERT_TRUE(shape.bar.has_value());
    EXPECT_TRUE(shapes.bars.at(*shape.bar).title.starts_with(layer.name))
        << shapes.bars[*shape.bar].title << " of " << layer.name;
  }
  EXPECT_EQ(layers.size(), scene.layers.size());
}

}  // namespace scene_shapes_test
}  // namespace palpa::detail
