// The shapes that a report's page turns: they lie where the field says, however coarse they are made.
#include "palpa/view/scene_shapes.h"

#include <gtest/gtest.h>

#include "palpa/mode/modes.h"
#include "palpa/volume/analytic.h"

namespace palpa::detail {
namespace scene_shapes_test {

TEST(SceneShapes, ABallIsABallInFewTriangles) {
  constexpr double radius_m = 0.05;
  Scene scene;
  scene.workspace.scale = 1.0;
  scene.workspace.center_m = Vec3{};
  const FieldRef field = scene.add("ball", sphere_field(radius_m));
  scene.add("surface", SurfaceAndFriction{.field = field, .levels = {{.name = "skin", .value = 0.0, .strength_n = 1.0}}});
  for (const std::size_t most : {std::size_t{2000}, std::size_t{20'000}}) {
    const SceneShapes shapes = scene_shapes(scene, worth_showing(scene, {}), {}, most);
    ASSERT_EQ(shapes.shapes.size(), 1u);
    const Shape& ball = shapes.shapes[0];
    EXPECT_EQ(ball.words, "skin");
    EXPECT_LE(ball.triangles.size(), most + most / 50);
    EXPECT_GT(ball.triangles.size(), most / 2);
    ASSERT_EQ(ball.normals.size(), ball.points_m.size());
    // A triangle of a ball that so many cover lies no deeper than the square of half its side over twice the radius.
    const double deep_m = 4.0 * radius_m / static_cast<double>(ball.triangles.size());
    for (std::size_t i = 0; i < ball.points_m.size(); ++i) {
      EXPECT_NEAR(norm(ball.points_m[i]), radius_m, deep_m + 2e-5);
      EXPECT_GT(dot(ball.normals[i], normalized(ball.points_m[i])), 0.98);
    }
    double volume_m3 = 0.0;  // turned outwards
    for (const auto& [a, b, c] : ball.triangles)
      volume_m3 += dot(ball.points_m[a], cross(ball.points_m[b], ball.points_m[c])) / 6.0;
    EXPECT_NEAR(volume_m3, 4.0 / 3.0 * 3.14159265 * radius_m * radius_m * radius_m, 0.01 * volume_m3);
  }
}

}  // namespace scene_shapes_test
}  // namespace palpa::detail
