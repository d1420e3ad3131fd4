// The limiter's state machine (docs/safety.md), in simulated time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/guard/guard_laws.h"

namespace palpa {
namespace guard_states_test {

constexpr double dt_s = 1e-3;

/// A limiter under a steady force and a still hand, unless a test changes them.
class GuardStates : public testing::Test {
 protected:
  Guard::Passed tick(const Vec3& force_n, std::uint32_t circumstances = 0, bool usable = true, const Vec3& step_m = {}) {
    return last_ = guard_.tick({.force_n = force_n,
                                .probe_step_m = step_m,
                                .time_step_s = dt_s,
                                .usable = usable,
                                .buttons = buttons_,
                                .circumstances = circumstances});
  }
  Guard::Passed ticks(int number, const Vec3& force_n, std::uint32_t circumstances = 0) {
    for (int i = 0; i < number; ++i) tick(force_n, circumstances);
    return last_;
  }
  /// Until the whole force goes out.
  void come_on(const Vec3& force_n) {
    ticks(10, {});
    for (int i = 0; i < 2000 && last_.state != GuardState::pass; ++i) tick(force_n);
    ASSERT_EQ(last_.command_n, force_n);
  }

  GuardOptions options_{.max_force_n = 3.3};
  Guard guard_{options_};
  Guard::Passed last_;
  std::uint32_t buttons_ = 0;
};

TEST_F(GuardStates, AStartWaitsForASmallForceAndComesByTheRamp) {
  EXPECT_TRUE(tick({2, 0, 0}).begins);
  for (int i = 0; i < 400; ++i) ASSERT_EQ(tick({2.0 + i % 2, 0, 0}).command_n, Vec3{}) << "a strong force keeps the gate shut";
  EXPECT_EQ(last_.cause, GuardCause::start);
  ticks(5, {0.1, 0, 0});
  double before_n = 0;
  int on_after = 0;
  for (; last_.state != GuardState::pass && on_after < 2000; ++on_after) {
    const double sent_n = tick({2, 0, 0}).command_n.x;
    ASSERT_GE(sent_n, before_n);
    ASSERT_LE(sent_n, 2.0 * (on_after + 2) * dt_s / options_.ramp_s + 1e-12);
    before_n = sent_n;
  }
  EXPECT_NEAR(on_after * dt_s, options_.ramp_s, 0.005);
}

TEST_F(GuardStates, AForceThatStaysOpensTheGateAsWell) {
  int waited = 0;
  while (tick({0, 1, 0}).command_n == Vec3{} && waited < 2000) ++waited;
  EXPECT_NEAR(waited * dt_s, 0.5, 0.01);
}

TEST_F(GuardStates, EveryFaultFallsToZeroInThreeTicksAndComesBackByGateAndRamp) {
  for (const Circumstance fault : {Circumstance::device_fault, Circumstance::link_lost, Circumstance::late, Circumstance::stops,
                                   Circumstance::other_hand, Circumstance::link_closed}) {
    guard_ = Guard(options_);
    come_on({3, 0, 0});
    EXPECT_EQ(tick({3, 0, 0}, bit_of(fault)).command_n, (Vec3{0.75, 0, 0}));
    EXPECT_EQ(tick({3, 0, 0}).command_n, (Vec3{0.1875, 0, 0}));
    EXPECT_EQ(tick({3, 0, 0}).command_n, Vec3{});
    EXPECT_TRUE(tick({3, 0, 0}).begins);
    ticks(3, {});
    EXPECT_EQ(last_.state, GuardState::waiting);
    ticks(2, {});
    EXPECT_EQ(tick({3, 0, 0}).state, GuardState::ramp);
    EXPECT_LT(last_.command_n.x, 0.05);
  }
}

TEST_F(GuardStates, WhatIsNotFiniteIsZeroAtOnce) {
  come_on({3, 0, 0});
  EXPECT_EQ(tick({3, std::numeric_limits<double>::quiet_NaN(), 0}).command_n, Vec3{});
  EXPECT_EQ(last_.state, GuardState::fault);
  EXPECT_EQ(tick({3, 0, 0}).state, GuardState::waiting);
}

TEST_F(GuardStates, AProbeThatIsNotKnownIsAFault) {
  come_on({3, 0, 0});
  EXPECT_EQ(tick({}, 0, false).state, GuardState::falling);
  EXPECT_EQ(last_.cause, GuardCause::no_position);
}

TEST_F(GuardStates, AFastHandIsBrakedUntilItIsSlow) {
  come_on({1, 0, 0});
  const Vec3 fast_m{2.5e-3, 0, 0}, slower_m{1.5e-3, 0, 0}, slow_m{0.5e-3, 0, 0};
  for (int i = 0; i < 30; ++i) tick({1, 0, 0}, 0, true, fast_m);
  EXPECT_TRUE(last_.brakes);
  EXPECT_EQ(last_.cause, GuardCause::speed);
  for (int i = 0; i < 30; ++i) tick({}, 0, true, slower_m);
  EXPECT_TRUE(last_.brakes) << "above half of the limit it is still fast";
  for (int i = 0; i < 30; ++i) tick({}, 0, true, slow_m);
  EXPECT_FALSE(last_.brakes);
}

TEST_F(GuardStates, APanicLastsUntilAPersonResumes) {
  come_on({3, 0, 0});
  tick({3, 0, 0}, bit_of(Circumstance::panic));
  ticks(3000, {});
  EXPECT_EQ(last_.state, GuardState::off);
  tick({std::numeric_limits<double>::infinity(), 0, 0});
  EXPECT_EQ(ticks(10, {}).state, GuardState::off) << "no other fault ends it";
  tick({}, bit_of(Circumstance::resume));
  EXPECT_EQ(ticks(10, {}).state, GuardState::ramp);
}

TEST_F(GuardStates, AMovingViewOrAStaleLinkLetsGoSoftlyAndWhatIsFeltBeginsAnew) {
  for (const Circumstance pause : {Circumstance::view_moves, Circumstance::link_stale}) {
    guard_ = Guard(options_);
    come_on({3, 0, 0});
    double before_n = 3.0;
    for (int i = 0; i < 60; ++i) {
      const double sent_n = tick({3, 0, 0}, bit_of(pause)).command_n.x;
      ASSERT_LE(sent_n, before_n);
      ASSERT_GE(sent_n, before_n - 0.07);
      before_n = sent_n;
    }
    EXPECT_EQ(before_n, 0.0);
    ticks(100, {3, 0, 0}, bit_of(pause));
    EXPECT_FALSE(last_.begins);
    EXPECT_TRUE(tick({3, 0, 0}).begins);
  }
}

TEST_F(GuardStates, WithADeadManNothingIsFeltUntilItIsHeld) {
  options_.dead_man_buttons = 2;
  guard_ = Guard(options_);
  EXPECT_EQ(ticks(2000, {}).state, GuardState::waiting);
  EXPECT_EQ(last_.cause, GuardCause::dead_man);
  buttons_ = 3;
  come_on({1, 0, 0});
  buttons_ = 1;
  EXPECT_EQ(tick({1, 0, 0}).state, GuardState::falling);
}

TEST_F(GuardStates, AForceMayFallAtOnceAndGrowsAndTurnsBySlew) {
  options_.slew_n_per_s = 100.0;
  guard_ = Guard(options_);
  come_on({3, 0, 0});
  EXPECT_EQ(tick({0.5, 0, 0}).command_n, (Vec3{0.5, 0, 0}));
  EXPECT_NEAR(tick({3, 0, 0}).command_n.x, 0.6, 1e-12);
  EXPECT_EQ(last_.state, GuardState::limited);
  const Vec3 turned_n = tick({0, 3, 0}).command_n;
  EXPECT_NEAR(norm(turned_n - Vec3{0, 0.1, 0}), 0.0, 1e-12) << "a turn is a fall and a growth";
}

TEST_F(GuardStates, MotorsThatGetWarmBearWhatTheyBearForEver) {
  options_.continuous_force_n = 0.88;
  guard_ = Guard(options_);
  come_on({3, 0, 0});
  const int cool = 300;
  EXPECT_EQ(ticks(cool, {3, 0, 0}).command_n.x, 3.0) << "a short push is not cut";
  ticks(200'000, {3, 0, 0});
  EXPECT_NEAR(last_.command_n.x, 0.88, 0.01);
  EXPECT_LE(guard_.warmth(), 1.0);
  ticks(100'000, {});
  EXPECT_LT(guard_.warmth(), 0.02);
}

TEST_F(GuardStates, EnergyThatNoModeBookedIsDampedAgainstTheMotion) {
  come_on({1, 0, 0});
  const Vec3 step_m{2e-4, 1e-4, 0};
  Guard::Passed passed;
  for (int i = 0; i < 100; ++i) {
    passed = guard_.tick({.force_n = {1, 0, 0}, .probe_step_m = step_m, .time_step_s = dt_s, .gained_j = 2e-4});
  }
  EXPECT_EQ(passed.state, GuardState::damped);
  const Vec3 damping_n = passed.command_n - Vec3{1, 0, 0};
  EXPECT_LT(dot(damping_n, step_m), 0.0);
  EXPECT_NEAR(norm(cross(normalized(damping_n), normalized(step_m))), 0.0, 1e-9);
  for (int i = 0; i < 3000; ++i) passed = guard_.tick({.force_n = {1, 0, 0}, .probe_step_m = step_m, .time_step_s = dt_s});
  EXPECT_EQ(passed.state, GuardState::pass) << "a budget that is kept again is not damped";
}

TEST(Guard, KeepsItsPromisesUnderRandomHands) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    test::RandomHand hand(seed);
    const GuardOptions options = hand.options();
    Guard guard(options);
    test::Judge judge(options);
    for (int i = 0; i < 20'000; ++i) {
      const GuardInput in = hand.next();
      const char* broken = judge.broken_by(in, guard, guard.tick(in));
      ASSERT_EQ(broken, nullptr) << "seed " << seed << ", tick " << i << ": broken: " << broken;
    }
  }
}

TEST(Guard, OfTheSameInputsGivesTheSameCommands) {
  test::RandomHand one(5), other(5);
  const GuardOptions options = one.options();
  other.options();
  Guard a(options), b(options);
  for (int i = 0; i < 50'000; ++i) ASSERT_EQ(a.tick(one.next()).command_n, b.tick(other.next()).command_n);
}

}  // namespace guard_states_test
}  // namespace palpa
