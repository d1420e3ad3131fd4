// Pictures of a map: positions of forces, view along the hand's axes.
#include "palpa/view/map_picture.h"

#include <gtest/gtest.h>

#include <array>

#include "palpa/base/load_error.h"
#include "palpa/view/colors.h"

namespace palpa {
namespace map_picture_test {

/// A map, 0.1 m to a side, with a force of 2 N at the positions where `felt` holds.
template <class Felt>
ForceMap map_of(int axis, const Felt& felt) {
  ForceMap map(map_slice(axis, 0.0, 0.1, 51));
  for (int k = 0; k < map.lattice.points[2]; ++k)
    for (int j = 0; j < map.lattice.points[1]; ++j)
      for (int i = 0; i < map.lattice.points[0]; ++i)
        if (felt(map.lattice.place_m(i, j, k))) {
          MapPoint& point = map.points[map.lattice.number(i, j, k)];
          point.first_contact_n = point.steady_n = {0.0, 0.0, 0.0};
          (axis == 0 ? point.steady_n.x : axis == 1 ? point.steady_n.y : point.steady_n.z) = 2.0;  // across: no arrows
        }
  std::fill(map.done.begin(), map.done.end(), std::uint8_t{1});
  return map;
}

/// Pixels of the colour of the largest force, and their mean position, from the lower left corner.
struct Spot {
  int pixels = 0;
  double x = 0.0, y = 0.0;
};
Spot spot_of(const ForceMap& map) {
  const Picture picture = map_picture(Scene{}, map);
  const detail::Color color = detail::force_colors(2.0).at(2.0).color;
  Spot spot;
  for (int y = 0; y < picture.height_px; ++y)
    for (int x = 0; x < picture.width_px * 85 / 100; ++x) {
      const std::uint8_t* const rgb = picture.rgb.data() + 3 * (static_cast<std::size_t>(y) * picture.width_px + x);
      const auto is_near = [](int byte, double share) { return std::abs(byte - 255.0 * share) < 3.0; };
      if (!is_near(rgb[0], color.red) || !is_near(rgb[1], color.green) || !is_near(rgb[2], color.blue)) continue;
      ++spot.pixels;
      spot.x += x;
      spot.y += picture.height_px - 1 - y;
    }
  spot.x /= std::max(1, spot.pixels);
  spot.y /= std::max(1, spot.pixels);
  return spot;
}

TEST(MapPicture, ShowsForcesWhereTheyAre) {
  for (const int axis : {0, 1, 2}) {
    // Across x the user is at the right, across y below; across z right is right.
    const auto right = [axis](const Vec3& p) { return axis == 0 ? p.z : p.x; };
    const auto up = [axis](const Vec3& p) { return axis == 1 ? -p.z : p.y; };
    const Spot all = spot_of(map_of(axis, [](const Vec3&) { return true; }));
    const Spot at_right = spot_of(map_of(axis, [&](const Vec3& p) { return right(p) > 0.02; }));
    const Spot at_top = spot_of(map_of(axis, [&](const Vec3& p) { return up(p) > 0.02; }));
    EXPECT_GT(all.pixels, 100000) << axis;
    EXPECT_NEAR(at_right.pixels, 0.3 * all.pixels, 0.02 * all.pixels);
    EXPECT_GT(at_right.x, all.x + 100);
    EXPECT_NEAR(at_right.y, all.y, 3);
    EXPECT_GT(at_top.y, all.y + 100);
    EXPECT_NEAR(at_top.x, all.x, 3);
  }
}

TEST(MapPicture, IsTheSameForTheSameMap) {
  const ForceMap map = map_of(0, [](const Vec3& p) { return norm(p) < 0.03; });
  EXPECT_EQ(map_picture(Scene{}, map).rgb, map_picture(Scene{}, map).rgb);
}

TEST(MapPicture, RefusesSizesThatCannotBeDrawn) {
  const ForceMap map = map_of(0, [](const Vec3&) { return false; });
  EXPECT_THROW(map_picture(Scene{}, map, {.width_px = 100}), LoadError);
  EXPECT_THROW(map_picture(Scene{}, map, {.height_px = 9000}), LoadError);
}

}  // namespace map_picture_test
}  // namespace palpa
