// A tick allocates nothing: every operator new of this program is counted.
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "palpa/session/session.h"
#include "tests/session/busy_scene.h"
#include "tests/session/hands.h"
#include "tests/solver/counted_allocations.h"

namespace palpa {
namespace allocation_test {

class Allocation : public testing::TestWithParam<bool> {};

TEST_P(Allocation, NoneInATick) {
  Session session(test::busy_scene(GetParam()));
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
  Session session(test::busy_scene(GetParam()));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double inf = std::numeric_limits<double>::infinity();
  const long before = test::allocations;
  for (int i = 0; i < 200; ++i) {
    for (const double bad : {nan, inf, -inf, 1e300, -1e5, 999.0}) {
      for (const double dt : {1e-3, 0.0, nan, 10.0}) {
        const Tick tick = session.tick({.position_m = {bad, 0.01, 0.02}, .velocity_m_per_s = Vec3{0, bad, 0}}, dt);
        ASSERT_TRUE(is_finite(tick.force_n) && is_finite(tick.proxy_m) && is_finite(tick.proxy_velocity_m_per_s));
        ASSERT_TRUE(std::isfinite(tick.error_bound_m) && std::isfinite(tick.energy.path_and_release_j) &&
                    std::isfinite(tick.energy.stored_j));
      }
    }
    session.tick({.position_m = {0, 0, 0.08}}, 1e-3);
  }
  EXPECT_EQ(test::allocations, before);
}

TEST_P(Allocation, NoneInATickOfDataThatMove) {
  Session session(test::busy_moving_scene(GetParam())), other(session.scene());
  test::Random random(1);
  const test::Wander hand(random, 0.09);
  const long before = test::allocations;
  int jumps = 0;
  double data_motion_j = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const Tick tick = session.tick({.position_m = hand.at(1e-3 * i), .valid = i % 997 != 996}, 1e-3);
    data_motion_j += std::abs(tick.energy.data_motion_j);
    for (const SessionEvent& e : session.events()) jumps += e.kind == SessionEventKind::warning;
    ASSERT_TRUE(is_finite(tick.force_n));
  }
  EXPECT_EQ(test::allocations, before);
  other.copy_state_from(session);
  EXPECT_EQ(test::allocations, before);
  EXPECT_GT(data_motion_j, 1e-4);
  EXPECT_GT(jumps, 0);
}

TEST_P(Allocation, NoneInATickOfATool) {
  Scene scene = test::busy_moving_scene(GetParam());
  scene.set(ToolOptions{.shape = ToolOptions::Shape::rod, .length_m = 0.03, .points = 16});
  Session session(scene), other(scene);
  test::Random random(1);
  const test::Wander hand(random, 0.09), turns(random, 1.0);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const long before = test::allocations;
  int in_contact = 0;
  for (int i = 0; i < 2000; ++i) {
    Probe probe{.position_m = hand.at(1e-3 * i), .valid = i % 997 != 996, .turn = turn_by(turns.at(1e-3 * i))};
    if (i % 499 == 250) probe.turn = {0.0, 0.0, nan, 0.0};
    const Tick tick = session.tick(probe, 1e-3);
    in_contact += norm(tick.force_n) > 1e-3;
    ASSERT_TRUE(is_finite(tick.force_n) && is_finite(tick.torque_nm));
  }
  other.copy_state_from(session);
  EXPECT_EQ(test::allocations, before);
  EXPECT_GT(in_contact, 200);
}

INSTANTIATE_TEST_SUITE_P(FormulaAndGrid, Allocation, testing::Bool());

}  // namespace allocation_test
}  // namespace palpa
