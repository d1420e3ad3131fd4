// A tick allocates nothing: every operator new of this program is counted.
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "palpa/field/analytic.h"
#include "palpa/field/grid.h"
#include "palpa/mode/follow.h"
#include "palpa/mode/surface_and_friction.h"
#include "palpa/mode/viscosity.h"
#include "palpa/tick/session.h"
#include "tests/core/counted_allocations.h"
#include "tests/tick/hands.h"

namespace palpa {
namespace {

Scene busy_scene(bool as_grid) {
  Scene scene({.stiffness_n_per_m = 800, .damping_ns_per_m = 0.5});
  const auto data = [&](const Volume& volume) { return as_grid ? sampled(volume, 48) : volume; };
  const FieldRef head = scene.add("head", data(head_phantom()));
  const FieldRef flow = scene.add("flow", data(burgers_vortex()), {.scale = 4.0});
  scene.add("skin",
            SurfaceAndFriction{.field = head,
                               .levels = {{.name = "skin", .value = -300, .strength_n = 0.8, .friction_coefficient = 0.3},
                                          {.name = "bone", .value = 300, .strength_n = 4.0, .friction_n = 0.2}}});
  scene.add("rail", Follow{.field = flow, .strength_n = 0.4, .drag_ns_per_m = 1.0});
  scene.add(
      "air",
      Viscosity{.field = head, .strength_n = {head, TransferFunction({{-1100, 0.1}, {-500, 0.0}})}, .drag_ns_per_m = 0.5});
  return scene;
}

class Allocation : public testing::TestWithParam<bool> {};

TEST_P(Allocation, NoneInATick) {
  Session session(busy_scene(GetParam()));
  test::Random random(1);
  const test::Wander hand(random, 0.09);
  const long before = test::allocations;
  int in_contact = 0;
  for (int i = 0; i < 5000; ++i) {
    const Tick tick = session.tick({.position_m = hand.at(1e-3 * i)}, 1e-3);
    in_contact += norm(tick.force_n) > 1e-3;
  }
  EXPECT_EQ(test::allocations, before);
  EXPECT_GT(in_contact, 500);
}

TEST_P(Allocation, NoneInABadTickEither) {
  Session session(busy_scene(GetParam()));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double inf = std::numeric_limits<double>::infinity();
  const long before = test::allocations;
  for (int i = 0; i < 200; ++i) {
    for (const double bad : {nan, inf, -inf, 1e300, -1e5, 999.0}) {
      for (const double dt : {1e-3, 0.0, nan, 10.0}) {
        const Tick tick = session.tick({.position_m = {bad, 0.01, 0.02}, .velocity_m_per_s = Vec3{0, bad, 0}}, dt);
        ASSERT_TRUE(is_finite(tick.force_n) && is_finite(tick.proxy_m) && is_finite(tick.proxy_velocity_m_per_s));
        ASSERT_TRUE(std::isfinite(tick.error_bound_m) && std::isfinite(tick.energy.path_j) &&
                    std::isfinite(tick.energy.stored_j));
      }
    }
    session.tick({.position_m = {0, 0, 0.08}}, 1e-3);
  }
  EXPECT_EQ(test::allocations, before);
}

// A head that moves and jumps back where its loop begins again, and a heart that beats: levels are carried, fade out and in.
TEST_P(Allocation, NoneInATickOfDataThatMove) {
  Scene scene = busy_scene(GetParam());
  const FieldRef other = scene.add_moving("other", GetParam() ? sampled(head_phantom(), 48) : head_phantom(),
                                          {{0.0, {}}, {0.03, {Mat3::identity(), 1.01, {0.001, 0.002, 0.0}}}});
  scene.add("heart", sampled(beating_chamber(), 33, 10), {.scale = 3.0});
  scene.add("moving_skin",
            SurfaceAndFriction{
                .field = other, .levels = {{.name = "skin", .value = -300, .strength_n = 20.0}}, .friction_coefficient = 0.3});
  scene.add("wall",
            SurfaceAndFriction{
                .field = {"heart.signal"}, .levels = {{.name = "wall", .value = 0.5, .strength_n = 0.8}}, .friction_n = 0.2});
  scene.time.play = TimeOptions::Play::loop;
  Session session(scene);
  test::Random random(1);
  const test::Wander hand(random, 0.09);
  const long before = test::allocations;
  int jumps = 0;
  double moved_j = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const Tick tick = session.tick({.position_m = hand.at(1e-3 * i), .valid = i % 997 != 996}, 1e-3);
    moved_j += std::abs(tick.energy.moved_j);
    for (const SessionEvent& e : session.events()) jumps += e.kind == SessionEventKind::warning;
    ASSERT_TRUE(is_finite(tick.force_n));
  }
  EXPECT_EQ(test::allocations, before);
  EXPECT_GT(moved_j, 1e-4);
  EXPECT_GT(jumps, 0);
}

INSTANTIATE_TEST_SUITE_P(FormulaAndGrid, Allocation, testing::Bool());

}  // namespace
}  // namespace palpa
