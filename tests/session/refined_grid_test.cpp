// Grids refined at a wall: samples of a tick by the cells at the proxy.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "palpa/data/derived.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"
#include "tests/session/hands.h"

namespace palpa {
namespace refined_grid_test {

constexpr double tick_s = 1e-3;
constexpr int n = 65;
constexpr double half_m = 0.1;  // the channel is a cube about the origin

/// Positions of planes [steps] with a constant ratio of successive cells, the first cell `first` [1] of their mean.
std::vector<double> refined(double first) {
  const auto places = [&](double factor) {
    std::vector<double> at{0.0};
    for (double width = first; at.size() < n; width *= factor) at.push_back(at.back() + width);
    return at;
  };
  double low = 1.0, high = 10.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (places(middle).back() > n - 1 ? high : low) = middle;
  }
  std::vector<double> at = places(low);
  at.back() = n - 1;
  return at;
}

/// A flow along x over a wall at the bottom (y), where the cells are thin: 1 − (1 − h)⁸ m/s at the share h [1] of the height.
Volume channel(double first) {
  GridGeometry grid{{n, n, n}, 2.0 * half_m / (n - 1) * Mat3::identity(), {-half_m, -half_m, -half_m}};
  grid.planes[1] = refined(first);
  const auto voxels = std::make_shared<std::vector<float>>();
  for (int i = 0; i < n * n * n; ++i) {
    const double h = grid.planes[1][static_cast<std::size_t>(i / n % n)] / (n - 1);
    voxels->insert(voxels->end(), {static_cast<float>(1.0 - std::pow(1.0 - h, 8)), 0.0f, 0.0f});
  }
  Volume volume;
  volume.format = "grid";
  volume.fields.push_back({"u", "m/s", grid_field(grid, {VoxelType::float32, 3, {voxels, voxels->data()}})});
  return volume;
}

double height_m(double speed_m_per_s) { return -half_m + 2.0 * half_m * (1.0 - std::pow(1.0 - speed_m_per_s, 1.0 / 8.0)); }

struct Felt {
  int waiting = 0, capped = 0;
  double largest_n = 0.0, furthest_m = 0.0, deepest_m = 0.0, bound_m = 0.0;
};

/// A hand below 0.2 m/s wanders through the channel, often to the wall.
Felt felt(const Scene& scene, double level_m = -half_m) {
  Session session(scene);
  test::Random random(3);
  Felt all;
  Vec3 at_m{0, 0, 0};
  test::Wander wander(random, 1.0);
  for (int i = 0; i < 2000; ++i) {
    const double t_s = tick_s * i;
    const Vec3 goal_m{0.08 * wander.at(t_s).x, -0.05 + 0.05 * std::cos(3.0 * t_s), 0.08 * wander.at(t_s).z};
    at_m += shortened(goal_m - at_m, 0.2 * tick_s);
    const Tick t = session.tick({.position_m = at_m}, tick_s);
    all.waiting += t.status == TickStatus::waiting;
    all.capped += t.status == TickStatus::capped || t.status == TickStatus::bad_input;
    all.largest_n = std::max(all.largest_n, norm(t.force_n));
    all.furthest_m = std::max(all.furthest_m, distance(t.proxy_m, at_m));
    all.deepest_m = std::max(all.deepest_m, level_m - t.proxy_m.y);
    all.bound_m = std::max(all.bound_m, t.error_bound_m);
  }
  return all;
}

Scene scene_in(const Volume& flow) {
  Scene scene({.stiffness_n_per_m = 300});
  scene.add("flow", flow);
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  return scene;
}

class RefinedGrid : public testing::TestWithParam<double> {};

TEST_P(RefinedGrid, ARailPullsNoMoreThanItIsStrong) {
  Scene scene = scene_in(channel(GetParam()));
  scene.add("rail", Follow{.field = {"flow"}, .strength_n = 0.4});
  const Felt all = felt(scene);
  EXPECT_GT(all.largest_n, 0.39);
  EXPECT_LE(all.largest_n, 0.4 + 1e-6);
  EXPECT_LE(all.furthest_m, 0.4 / 300 + 1e-6);
  EXPECT_LE(all.waiting, 20);
  EXPECT_EQ(all.capped, 0);
}

// In the thinnest layer along the wall, a hand of 0.1 m/s stays within a tick's budget of steps.
TEST_P(RefinedGrid, AlongTheWallNothingWaits) {
  Scene scene = scene_in(channel(GetParam()));
  scene.add("rail", Follow{.field = {"flow"}, .strength_n = 0.4});
  Session session(scene);
  for (int i = 0; i < 400; ++i) {
    const Tick t = session.tick({.position_m = {-0.04 + 0.1 * tick_s * i, -half_m + 1e-6, 0.0}}, tick_s);
    ASSERT_EQ(t.status, TickStatus::complete) << i;
  }
}

// Far from the wall cells are thick, and so are the steps of a hand of 1 m/s there.
TEST_P(RefinedGrid, FarFromTheWallStepsAreLong) {
  Scene scene = scene_in(channel(GetParam()));
  scene.add("rail", Follow{.field = {"flow"}, .strength_n = 0.4});
  Session session(scene);
  for (int i = 0; i < 100; ++i)
    EXPECT_LE(session.tick({.position_m = {-0.05 + 1.0 * tick_s * i, 0.06, 0.0}}, tick_s).sub_steps, 4) << i;
}

// A magnitude's level is at the flow's speed, without pending motion. A plane of s newtons at x has a proven bound of
// √(s ε |x| / k) by the rounding of its position alone, which is above `exact_bound_m` at 100 N.
TEST_P(RefinedGrid, ALevelOfAMagnitudeHoldsWhereItIs) {
  constexpr double s_n = 100.0, k_n_per_m = 300.0, furthest_m = 0.2;
  Scene scene = scene_in(channel(GetParam()));
  scene.add("wall", SurfaceAndFriction{.field = {"magnitude(flow)"},
                                       .solid = SurfaceAndFriction::Solid::low,
                                       .levels = {{.value = 0.5, .strength_n = s_n}}});
  const Felt all = felt(scene, height_m(0.5));
  EXPECT_GT(all.largest_n, 1.0);
  EXPECT_LE(all.deepest_m, 2e-4) << "the level of the interpolant";
  EXPECT_EQ(all.waiting, 0);
  EXPECT_LE(all.bound_m, std::sqrt(s_n * std::numeric_limits<double>::epsilon() * furthest_m / k_n_per_m));
}

TEST_P(RefinedGrid, WhereNothingIsFeltNothingWaits) {
  Scene scene = scene_in(channel(GetParam()));
  scene.add("thick", Viscosity{.field = {"magnitude(flow)"},
                               .strength_n = {{"magnitude(flow)"}, TransferFunction({{2.0, 0.0}, {3.0, 1.0}})}});
  const Felt all = felt(scene);
  EXPECT_EQ(all.waiting, 0);
  EXPECT_EQ(all.largest_n, 0.0);
}

INSTANTIATE_TEST_SUITE_P(FirstCell, RefinedGrid, testing::Values(1e-3, 1e-5));

// Moving data are on an equal grid, and are sampled alike.
TEST(RefinedGrid, ThatMovesIsNoFiner) {
  Scene scene({.stiffness_n_per_m = 300});
  Volume flow = channel(1e-5);
  flow.fields[0].field = derived(Derivation::magnitude, flow.fields[0].field);
  scene.add_moving("flow", flow, {{0.0, {}}, {1.0, {Mat3::identity(), 1.0, {0.001, 0.0, 0.0}}}});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  scene.add("wall",
            SurfaceAndFriction{
                .field = {"flow"}, .solid = SurfaceAndFriction::Solid::low, .levels = {{.value = 0.5, .strength_n = 100.0}}});
  scene.edit<TimeOptions>([&](auto& time) { time.play = TimeOptions::Play::loop; });
  const Felt all = felt(scene, height_m(0.5));
  EXPECT_GT(all.largest_n, 1.0);
  EXPECT_LE(all.waiting, 20);
}

}  // namespace refined_grid_test
}  // namespace palpa
