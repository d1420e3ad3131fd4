// Paths along fields: streamlines, convergence, rate independence.
#include "tests/path/lines.h"

#include <gtest/gtest.h>

#include <numbers>

#include "palpa/data/analytic.h"
#include "palpa/data/filter.h"
#include "palpa/data/sampled.h"
#include "palpa/file/read_volume.h"
#include "palpa/mode/modes.h"
#include "tests/laws/shipped_scenes.h"
#include "tests/session/hands.h"

namespace palpa::test {
namespace lines_test {

constexpr double most_per_turn_m = 0.01 * std::numbers::pi * follow_step_m;

TEST(FollowPath, StaysOnCirclesAndHelices) {
  for (const double rise : {0.0, 2e-3}) {
    for (const double radius : {0.010, 0.030}) {
      const FollowDrift drift = measure_follow(helical_field(rise), radius, rise, 3);
      EXPECT_LT(drift.first_turn_m, most_per_turn_m) << radius << " m, rising " << rise << " m";
      EXPECT_LT(drift.per_turn_m, most_per_turn_m) << radius << " m, rising " << rise << " m";
    }
  }
}

TEST(FollowPath, StaysOnASampledVortex) {
  const FieldPtr vortex = sampled(*lamb_oseen_vortex().fields.front().field, 128);
  for (const Filter filter : {Filter::trilinear, Filter::smooth}) {
    for (const double radius : {0.008, 0.010, 0.015}) {
      const FollowDrift drift = measure_follow(in_floats(*vortex, filter), radius, 0.0, 3);
      EXPECT_LT(drift.per_turn_m, most_per_turn_m) << name_of(filter) << ", " << radius << " m";
    }
  }
}

TEST(FollowPath, IsTheSameAgainstTheField) {
  std::vector<Vec3> paths[2];
  for (int turned = 0; turned < 2; ++turned) {
    Scene scene = plain_scene({.stiffness_n_per_m = 800});
    const FieldRef flow = scene.add("flow", volume_of(helical_field(2e-3, turned ? -1.0 : 1.0), "m/s"));
    scene.add("rail", Follow{.field = flow, .strength_n = 0.3});
    Session session(scene);
    Random random(4);
    const Wander hand(random, 0.05);
    for (int i = 0; i < 2000; ++i) paths[turned].push_back(session.tick({.position_m = hand.at(i * 1e-3)}, 1e-3).proxy_m);
  }
  EXPECT_EQ(paths[0], paths[1]);
}

// The main direction of diffusion in a measured brain, with the file's signs and with half of them flipped at random.
TEST(FollowPath, IsTheSameWhateverTheSignsOfAMeasuredBrain) {
  if (const std::string missing = missing_for("dti_brain"); !missing.empty()) GTEST_SKIP() << missing;
  VolumeRequest request;
  request.files = {shared_data() / "dti_brain" / "V1.nii.gz"};
  request.as = "vector";
  const FieldPtr brain = read_volume(request, {.reader = reader()}).fields.front().field;
  const GridView& grid = *grid_below(*brain);
  ASSERT_EQ(grid.voxels.type, VoxelType::float32);
  const auto* values = static_cast<const float*>(grid.voxels.data.get());
  auto turned = std::make_shared<std::vector<float>>(values, values + 3 * grid.geometry.voxels());
  Random random(8);
  for (std::size_t v = 0; v < turned->size(); v += 3) {
    if (random.below(2) == 0) continue;
    for (std::size_t c = v; c < v + 3; ++c) (*turned)[c] = -(*turned)[c];
  }
  const FieldPtr other = grid_field(grid.geometry, {VoxelType::float32, 3, std::shared_ptr<const void>(turned, turned->data())},
                                    grid.scale, grid.offset);
  std::vector<Vec3> paths[2];
  double felt_n = 0.0;
  for (int which = 0; which < 2; ++which) {
    Scene scene = plain_scene({.stiffness_n_per_m = 600});
    const FieldRef tracts = scene.add("tracts", volume_of(signless(which == 0 ? brain : other), ""));
    scene.edit<Workspace>([&](auto& workspace) { workspace.center_m = brain->bounds_m().centre_m(); });
    scene.add("rail", Follow{.field = tracts, .strength_n = 0.4});
    Session session(scene);
    Random same(6);
    const Wander hand(same, 0.04);
    for (int i = 0; i < 4000; ++i) {
      const Tick tick = session.tick({.position_m = hand.at(i * 1e-3)}, 1e-3);
      paths[which].push_back(tick.proxy_m);
      felt_n = std::max(felt_n, norm(tick.force_n));
    }
  }
  EXPECT_GT(felt_n, 0.1);
  EXPECT_EQ(paths[0], paths[1]);
}

class OrderOfConvergence : public testing::TestWithParam<OrderCase> {};

// Orders of docs/path.md: two where the direction alone turns (planes with the data, a force along them), one where a force
// that resists motion turns with it.
double stated_order(const std::string& mode) { return mode == "surface" || mode == "vortex_plane" ? 2.0 : 1.0; }

// The first comparison that converges more slowly than that order, in words; empty: none.
std::string slower_than(double stated, const Order& order) {
  for (std::size_t i = 0; i < order.orders.size(); ++i) {
    if (order.differences_m[i + 1] < order.settled_m || order.orders[i] > stated - 0.3) continue;
    return "differences of " + std::to_string(1e6 * order.differences_m[i]) + " and " +
           std::to_string(1e6 * order.differences_m[i + 1]) + " um from " + std::to_string(Order::steps[i]) + " ticks on";
  }
  return {};
}

TEST_P(OrderOfConvergence, IsAsStated) {
  const Order order = measure_order(GetParam());
  EXPECT_TRUE(order.slides);
  EXPECT_EQ(order.events, 0);
  EXPECT_EQ(slower_than(stated_order(GetParam().name), order), "");
}

// Paths of order one do not pass for order two; nor do levels sampled at a tick's start only.
TEST(OrderTwo, IsNotFoundInPathsOfOrderOne) {
  int compared = 0;
  for (const OrderCase& one : order_cases()) {
    if (stated_order(one.name) > 1.0) continue;
    const Order order = measure_order(one);
    if (order.differences_m[2] < order.settled_m) continue;  // too small to compare
    EXPECT_NE(slower_than(2.0, order), "") << one;
    ++compared;
  }
  EXPECT_GT(compared, 8);
}

TEST(OrderTwo, IsNotFoundInLevelsSeenFromTheStart) {
  for (const OrderCase& one : order_cases()) {
    if (stated_order(one.name) < 2.0) continue;
    const Order order = measure_order(one, false);
    EXPECT_TRUE(order.slides) << one;
    EXPECT_NE(slower_than(2.0, order), "") << one;
  }
}

// Strengths only, on data of every kind with strengths; the hand stays on one side of every level.
Scene strengths_only(int number) {
  Scene scene = plain_scene({.stiffness_n_per_m = 600});
  const FieldRef ball = scene.add("ball", sampled(sphere_field(0.05), 96));
  const FieldRef flow = scene.add("flow", sampled(lamb_oseen_vortex(), 96));
  if (number == 0) {
    scene.add("surface",
              SurfaceAndFriction{
                  .field = ball, .levels = {{.name = "skin", .value = 0.0, .strength_n = 100.0}}, .friction_coefficient = 0.2});
  } else {
    scene.add("rail", Follow{.field = flow, .strength_n = 0.4});
    scene.add("thick", Viscosity{.field = flow, .strength_n = 0.2});
  }
  return scene;
}

TEST(RateIndependence, HoldsFromATenthToTenTimesTheSpeed) {
  for (const int number : {0, 1}) {
    const Scene scene = strengths_only(number);
    Random random(9);
    const Wander hand(random, number == 0 ? 0.006 : 0.02);
    // Not deep: towards the edge of the data the surface yields at k/2 × the depth in them.
    const Vec3 middle = number == 0 ? Vec3{0, 0, 0.046} : Vec3{0.01, 0, 0};
    std::vector<Vec3> corners;
    for (int i = 0; i < 40; ++i) corners.push_back(middle + hand.at(0.0) + Vec3{0, 0, 0.0004 * (40 - i)});
    for (int i = 0; i < 200; ++i) corners.push_back(middle + hand.at(i * 0.004));
    const Rate rate = measure_rate({&scene, corners});
    EXPECT_GT(rate.corners, 100) << rate.waiting << " wait, " << rate.differing << " differ in events";
    EXPECT_LT(rate.slow_max_h, 1.0);
    EXPECT_LT(rate.fast_max_h, 1.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, OrderOfConvergence, testing::ValuesIn(order_cases()), [](const auto& one) {
  std::string name = one.param.name;
  std::erase(name, ',');
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

}  // namespace lines_test
}  // namespace palpa::test
