// The limiter's laws for a torque beside a force, in simulated time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpa/loop/clutch_mapping.h"
#include "palpa/guard/guard.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace guard_torque_test {

using test::Random;

constexpr double dt_s = 1e-3;
constexpr double radius_m = 0.04;
constexpr double reach_m = 0.1;

/// A limiter between a tool and a device with torque.
class GuardTorque : public testing::Test {
 protected:
  Guard::Passed tick(const Wrench& wrench, std::uint32_t circumstances = 0, const Vec3& turn_rad = {}, double gained_j = 0.0) {
    return last_ = guard_.tick({.force_n = wrench.force_n,
                                .time_step_s = dt_s,
                                .circumstances = circumstances,
                                .gained_j = gained_j,
                                .torque_nm = wrench.torque_nm,
                                .probe_turn_step_rad = turn_rad,
                                .turning_radius_m = radius_m,
                                .reach_m = reach_m});
  }
  void come_on(const Wrench& wrench) {
    guard_ = Guard(options_);
    for (int i = 0; i < 10; ++i) tick({});
    for (int i = 0; i < 2000 && last_.state != GuardState::pass; ++i) tick(wrench);
    ASSERT_EQ(last_.command_n, wrench.force_n);
    ASSERT_EQ(last_.command_nm, wrench.torque_nm);
  }

  GuardOptions options_{.max_force_n = 3.3, .max_torque_nm = 0.2};
  Guard guard_{options_};
  Guard::Passed last_;
};

TEST_F(GuardTorque, ShortensEachToItsOwnLimitAndKeepsItsDirection) {
  come_on({{1, 2, 0}, {0, 0.1, 0.1}});
  for (int i = 0; i < 2000; ++i) tick({{1, 2, 0}, {0, 3, 4}});
  EXPECT_EQ(last_.command_n, (Vec3{1, 2, 0})) << "the force is within its limit";
  EXPECT_NEAR(distance(last_.command_nm, 0.2 * Vec3{0, 0.6, 0.8}), 0.0, 1e-12);
  EXPECT_LE(norm(last_.command_nm), 0.2);
  EXPECT_EQ(last_.state, GuardState::limited);
  for (int i = 0; i < 2000; ++i) tick({{30, 40, 0}, {0, 0, 0.1}});
  EXPECT_NEAR(distance(last_.command_n, 3.3 * Vec3{0.6, 0.8, 0}), 0.0, 1e-12);
  EXPECT_EQ(last_.command_nm, (Vec3{0, 0, 0.1}));
}

TEST_F(GuardTorque, AloneLimitsBothAsWell) {
  Random random(3);
  const Guard guard(GuardOptions{.max_force_n = 2.0, .motors = false, .max_torque_nm = 0.1});
  for (int i = 0; i < 10'000; ++i) {
    const Vec3 force_n = random.in_cube(4.0), torque_nm = random.in_cube(0.2);
    const Guard::Passed passed = guard.pass(force_n, torque_nm);
    ASSERT_LE(norm(passed.command_n), 2.0);
    ASSERT_LE(norm(passed.command_nm), 0.1);
    ASSERT_NEAR(norm(cross(passed.command_nm, torque_nm)), 0.0, 1e-16);
    ASSERT_GE(dot(passed.command_nm, torque_nm), 0.0);
    const bool is_within = norm(force_n) <= 2.0 && norm(torque_nm) <= 0.1;
    ASSERT_EQ(passed.state, is_within ? GuardState::pass : GuardState::limited);
  }
}

TEST_F(GuardTorque, GrowsAndTurnsByItsSlewTimesTheTurningRadius) {
  options_.slew_n_per_s = 100.0;
  come_on({{0, 0, 0}, {0.1, 0, 0}});
  EXPECT_EQ(tick({{}, {0.05, 0, 0}}).command_nm, (Vec3{0.05, 0, 0})) << "it may fall at once";
  EXPECT_NEAR(tick({{}, {0.2, 0, 0}}).command_nm.x, 0.05 + radius_m * 100.0 * dt_s, 1e-12);
  EXPECT_EQ(last_.state, GuardState::limited);
  EXPECT_NEAR(distance(tick({{}, {0, 0.2, 0}}).command_nm, {0, radius_m * 100.0 * dt_s, 0}), 0.0, 1e-12);
}

TEST_F(GuardTorque, ComesByTheSameRampAndFallsByTheSameShares) {
  const Wrench wanted{{2, 0, 0}, {0, 0.1, 0}};
  for (int i = 0; i < 10; ++i) tick({});
  for (int i = 0; i < 2000 && last_.state != GuardState::pass; ++i) {
    tick(wanted);
    ASSERT_NEAR(last_.command_n.x / 2.0, last_.command_nm.y / 0.1, 1e-12);
  }
  ASSERT_EQ(last_.command_nm, wanted.torque_nm);
  for (const double left : {0.25, 0.0625, 0.0}) {
    tick(wanted, bit_of(Circumstance::device_fault));
    EXPECT_EQ(last_.command_nm, left * wanted.torque_nm);
    EXPECT_EQ(last_.command_n, left * wanted.force_n);
  }
  come_on(wanted);
  for (int i = 1; i <= 51; ++i) {
    tick(wanted, bit_of(Circumstance::view_moves));
    EXPECT_NEAR(last_.command_nm.y, 0.1 * std::max(0.0, 1.0 - i * dt_s / 0.05), 1e-12);
  }
  EXPECT_EQ(last_.command_nm, Vec3{});
}

TEST_F(GuardTorque, KeepsTheGateShutWhileItIsLarge) {
  for (int i = 0; i < 400; ++i) ASSERT_EQ(tick({{}, {0, 0.05 + 0.02 * (i % 2), 0}}).command_nm, Vec3{});
  EXPECT_EQ(last_.state, GuardState::waiting);
  for (int i = 0; i < 6; ++i) tick({{}, {0, 0.1 * radius_m, 0}});
  EXPECT_EQ(last_.state, GuardState::ramp) << "it is small as a force at the turning radius";
}

TEST_F(GuardTorque, ThatIsNotFiniteIsAFaultOfBoth) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    come_on({{3, 0, 0}, {0, 0.1, 0}});
    tick({{3, 0, 0}, {0, bad, 0}});
    EXPECT_EQ(last_.command_n, Vec3{});
    EXPECT_EQ(last_.command_nm, Vec3{});
    EXPECT_EQ(last_.state, GuardState::fault);
    EXPECT_EQ(last_.cause, GuardCause::not_finite);
    EXPECT_EQ(Guard(3.3).pass({1, 0, 0}, {bad, 0, 0}).state, GuardState::fault) << "also where no torque is driven";
  }
}

TEST_F(GuardTorque, WithoutMotorsForItIsZeroAndChangesNoForce) {
  options_.max_torque_nm = 0.0;
  Guard with_torque(options_), without(options_);
  Random random(4);
  for (int i = 0; i < 20'000; ++i) {
    GuardInput in{.force_n = random.in_cube(i % 4000 < 100 ? 0.1 : 4.0),
                  .probe_step_m = random.in_cube(1e-4),
                  .time_step_s = dt_s,
                  .gained_j = random.uniform(0.0, 1e-4)};
    const Guard::Passed plain = without.tick(in);
    in.torque_nm = random.in_cube(5.0);
    const Guard::Passed passed = with_torque.tick(in);
    ASSERT_EQ(passed.command_nm, Vec3{});
    ASSERT_EQ(passed.command_n, plain.command_n);
    ASSERT_EQ(passed.state, plain.state);
  }
  EXPECT_EQ(Guard(3.3).pass({1, 0, 0}, {0, 1, 0}).state, GuardState::pass);
}

TEST_F(GuardTorque, AHandThatTurnsTooFastIsLetGo) {
  const Wrench wanted{{1, 0, 0}, {0, 0.1, 0}};
  const Vec3 slow_rad{0, 0, 0.9 * options_.max_speed_m_per_s / reach_m * dt_s};
  come_on(wanted);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(tick(wanted, 0, slow_rad).state, GuardState::pass);
  for (int i = 0; i < 30; ++i) tick(wanted, 0, 1.3 * slow_rad);
  EXPECT_EQ(last_.cause, GuardCause::speed);
  EXPECT_TRUE(last_.brakes);
  EXPECT_EQ(last_.command_nm, Vec3{});
  for (int i = 0; i < 40; ++i) tick({}, 0, 0.4 * slow_rad);
  EXPECT_FALSE(last_.brakes);
}

TEST_F(GuardTorque, WarmMotorsLowerBothByOneShare) {
  options_.continuous_force_n = 0.88;
  come_on({{3, 0, 0}, {0, 0.15, 0}});
  for (int i = 0; i < 200'000; ++i) tick({{3, 0, 0}, {0, 0.15, 0}});
  EXPECT_NEAR(last_.command_n.x, 0.88, 0.01);
  EXPECT_NEAR(last_.command_nm.y, 0.88 / 3.3 * 0.2, 0.01 / 3.3 * 0.2) << "the same share of its limit";
  // A torque alone warms as well.
  come_on({{}, {0, 0.2, 0}});
  for (int i = 0; i < 200'000; ++i) tick({{}, {0, 0.2, 0}});
  EXPECT_NEAR(last_.command_nm.y, 0.88 / 3.3 * 0.2, 0.01 / 3.3 * 0.2);
  EXPECT_LE(guard_.warmth(), 1.0 + 1e-9);
}

TEST_F(GuardTorque, EnergyThatNoModeBookedIsDampedAgainstTheTurnAsWell) {
  const Wrench wanted{{1, 0, 0}, {0, 0.1, 0}};
  const Vec3 turn_rad{2e-3, 0, 1e-3};
  come_on(wanted);
  for (int i = 0; i < 100; ++i) tick(wanted, 0, turn_rad, 2e-4);
  EXPECT_EQ(last_.state, GuardState::damped);
  EXPECT_EQ(last_.command_n, wanted.force_n) << "the point is at rest";
  // Whole damping: 5 N·s/m at the turning radius.
  const Vec3 damping_nm = last_.command_nm - wanted.torque_nm;
  EXPECT_NEAR(distance(damping_nm, -5.0 * radius_m * radius_m / dt_s * turn_rad), 0.0, 1e-6);
  options_.max_turn_damping_nms_per_rad = 1e-3;
  come_on(wanted);
  for (int i = 0; i < 100; ++i) tick(wanted, 0, turn_rad, 2e-4);
  EXPECT_NEAR(distance(last_.command_nm - wanted.torque_nm, -1e-3 / dt_s * turn_rad), 0.0, 1e-6) << "the device's limit";
}

// ---- the grip ----

TEST(ClutchMapping, ATurnedViewTurnsTheToolAsItTurnsPositions) {
  Random random(5);
  for (int run = 0; run < 200; ++run) {
    const Turn view = turn_by(random.in_cube(1.7)), handle = turn_by(random.in_cube(1.7));
    const Vec3 foot_m = random.in_cube(0.1), place_m = random.in_cube(0.1), torque_nm = random.in_cube(0.2);
    ClutchMapping grip({});
    grip.turn(matrix_of(view));
    grip.hold({.position_m = place_m, .valid = true, .turn = handle}, dt_s);
    const Probe probe = grip.hold({.position_m = place_m, .valid = true, .turn = handle}, dt_s).probe;
    ASSERT_TRUE(is_unit(probe.turn, 1e-12));
    // The whole tool is seen as it is held.
    ASSERT_NEAR(distance(rotated(probe.turn, foot_m), rotated(view, rotated(handle, foot_m))), 0.0, 1e-12);
    // Work is work: a small turn of the handle.
    const Vec3 turn_rad = 1e-6 * random.in_cube(1.0);
    const Turn turned = turned_further(handle, turn_rad);
    const Probe after = grip.hold({.position_m = place_m, .valid = true, .turn = turned}, dt_s).probe;
    const Vec3 device_nm = grip.at_device({{}, torque_nm}).torque_nm;
    ASSERT_NEAR(dot(torque_nm, rotation_between_rad(probe.turn, after.turn)), dot(device_nm, turn_rad), 1e-15);
  }
}

TEST(ClutchMapping, TheClutchLeavesTheOrientationToTheHandle) {
  ClutchMapping grip({.clutch_buttons = 1});
  const Turn turned = turn_by({0, 0.3, 0});
  EXPECT_EQ(grip.hold({.valid = true}, dt_s).probe.turn, Turn{}) << "of a device without one";
  const ClutchMapping::Held held = grip.hold({.position_m = {0.05, 0, 0}, .valid = true, .buttons = 1, .turn = turned}, dt_s);
  EXPECT_TRUE(held.moves);
  EXPECT_EQ(held.probe.position_m, Vec3{});
  EXPECT_EQ(held.probe.turn, turned);
}

TEST(ClutchMapping, LeavesAQuaternionThatIsNoTurnAsItIs) {
  ClutchMapping grip({});
  grip.turn(matrix_of(turn_by({0.4, 0, 0})));
  EXPECT_FALSE(is_unit(grip.hold({.valid = true, .turn = Turn{0, 0, 0, 0}}, dt_s).probe.turn, 1e-3));
  EXPECT_FALSE(is_unit(grip.hold({.valid = true, .turn = Turn{2, 0, 0, 0}}, dt_s).probe.turn, 1e-3));
  EXPECT_FALSE(is_unit(grip.hold({.valid = true, .turn = Turn{NAN, 0, 0, 0}}, dt_s).probe.turn, 1e-3));
}

}  // namespace guard_torque_test
}  // namespace palpa
