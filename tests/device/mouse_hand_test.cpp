// The pointer's hand: motion under force, and reach.
#include "palpa/device/mouse_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <thread>

namespace palpa {
namespace pointer_test {

// Runs until no motion is pending.
void settle(MouseHand& pointer) {
  for (int n = 0; n < 1000; ++n) pointer.pass(1e-3);
}
Vec3 place_m(MouseHand& pointer) {
  settle(pointer);
  return pointer.read().position_m;
}

TEST(MouseHand, IsAtOnceWhereItIsPutAndGoesOnFromThere) {
  MouseHand pointer;
  pointer.move({0.05, 0.0, 0.0});
  pointer.pass(1e-3);
  pointer.put({0.01, 0.02, -0.03});
  pointer.pass(1e-3);
  const DeviceState there = pointer.read();
  EXPECT_EQ(there.position_m, (Vec3{0.01, 0.02, -0.03})) << "what it was to move before is forgotten";
  EXPECT_FALSE(there.valid) << "so that nothing is felt on the way";
  EXPECT_TRUE(pointer.read().valid);
  EXPECT_EQ(*pointer.read().velocity_m_per_s, Vec3{});
  pointer.move({0.001, 0.0, 0.0});
  pointer.put({0.0, 0.02, 0.0});
  pointer.move({0.0, 0.0, 0.004});
  EXPECT_LT(distance(place_m(pointer), {0.0, 0.02, 0.004}), 1e-12) << "motions before it was put are forgotten, later ones not";
  pointer.put({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0});
  pointer.put({9.0, 0.0, 0.0});
  EXPECT_NEAR(norm(place_m(pointer)), MouseHand::Options{}.radius_m, 1e-12) << "the ball is its end";
}

TEST(MouseHand, GoesWhereItIsMovedInHoweverManyParts) {
  MouseHand whole, parts;
  whole.move({0.01, -0.02, 0.03});
  for (int n = 0; n < 100; ++n) {
    parts.move({0.0001, -0.0002, 0.0003});
    parts.pass(1e-3);
  }
  EXPECT_LT(distance(place_m(whole), {0.01, -0.02, 0.03}), 1e-12);
  EXPECT_LT(distance(place_m(parts), place_m(whole)), 1e-12);
}

TEST(MouseHand, IsSmoothHoweverSeldomItIsTold) {
  MouseHand pointer({.now = []() noexcept { return std::chrono::steady_clock::time_point(); }});
  pointer.move({0.02, 0, 0});
  double last_m = 0.0;
  for (int n = 0; n < 200; ++n) {
    pointer.pass(1e-3);
    const double now_m = pointer.read().position_m.x;
    EXPECT_GE(now_m, last_m);
    EXPECT_LT(now_m - last_m, 0.1 * 0.02) << "a jump of a mouse is spread over many ticks";
    last_m = now_m;
  }
}

TEST(MouseHand, GoesEvenlyBetweenTheMotionsOfASlowWindow) {
  MouseHand pointer({.now = []() noexcept { return std::chrono::steady_clock::time_point(); }});
  // Every 40 ± 5 ms, as over a network; without the spread, the hand would nearly stop before each motion.
  double least_m = 1.0, most_m = 0.0, last_m = 0.0;
  int next = 0;
  for (int n = 0; n < 2000; ++n) {
    if (n == next) {
      pointer.move({0.002, 0, 0});
      next += n % 2 == 0 ? 35 : 45;
    }
    pointer.pass(1e-3);
    const double now_m = pointer.read().position_m.x;
    if (n > 400 && now_m < 0.11) {
      least_m = std::min(least_m, now_m - last_m);
      most_m = std::max(most_m, now_m - last_m);
    }
    last_m = now_m;
  }
  EXPECT_GT(least_m, 0.5 * 0.002 / 40);
  EXPECT_LT(most_m, 2.0 * 0.002 / 40);
}

TEST(MouseHand, IsSlowerAgainstAForceOnly) {
  for (const double strength_n : {0.5, 1.5, 3.0}) {
    const auto way_m = [&](const Vec3& way) {
      MouseHand pointer;
      pointer.write({0, 0, strength_n});
      pointer.move(way);
      return place_m(pointer);
    };
    const double ratio = 1.0 + 2.0 * strength_n / 3.3;
    EXPECT_NEAR(way_m({0, 0, -0.01}).z, -0.01 / ratio, 1e-9);
    EXPECT_NEAR(way_m({0, 0, 0.01}).z, 0.01, 1e-9);
    EXPECT_NEAR(way_m({0.01, 0, 0}).x, 0.01, 1e-9);
    EXPECT_GE(0.01 / -way_m({0, 0, -0.01}).z, 1.0);
    EXPECT_LE(0.01 / -way_m({0, 0, -0.01}).z, 3.0);
  }
}

TEST(MouseHand, GoesNoFurtherThanTheLargestForceHolds) {
  MouseHand pointer;
  // A wall at 0 as a spring would render it.
  for (int n = 0; n < 20000; ++n) {
    pointer.move({0, 0, -1e-4});
    pointer.pass(1e-3);
    const double depth_m = -pointer.read().position_m.z;
    pointer.write({0, 0, std::min(3.3, 500.0 * std::max(0.0, depth_m))});
  }
  EXPECT_LT(-pointer.read().position_m.z, 3.3 / 500.0 + 2e-4);
  pointer.move({0, 0, 0.03});
  EXPECT_GT(place_m(pointer).z, 0.0) << "the way back is free";
}

TEST(MouseHand, StaysInItsBallAndTakesNoNonsense) {
  MouseHand pointer;
  pointer.move({5, 5, 5});
  EXPECT_NEAR(norm(place_m(pointer)), 0.12, 1e-12);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  pointer.move({nan, 0, 0});
  pointer.write({nan, 0, 0});
  pointer.pass(nan);
  EXPECT_TRUE(is_finite(place_m(pointer)));
  pointer.press(5);
  EXPECT_EQ(pointer.read().buttons, 5u);
}

TEST(MouseHand, TurnsItsHandleWhereItIsTurned) {
  MouseHand pointer({.turn = turn_by({0, 0, 0.5})});
  EXPECT_EQ(*pointer.read().turn, turn_by({0, 0, 0.5}));
  pointer.turn({0.3, 0, 0});
  pointer.pass(1e-3);
  pointer.turn({0, -1.2, 0});
  pointer.turn({std::numeric_limits<double>::quiet_NaN(), 0, 0});
  settle(pointer);
  const Turn wanted = turn_by({0, -1.2, 0}) * turn_by({0.3, 0, 0}) * turn_by({0, 0, 0.5});
  EXPECT_LT(norm(rotation_between_rad(*pointer.read().turn, wanted)), 1e-9);
  EXPECT_TRUE(is_unit(*pointer.read().turn, 1e-12));
  pointer.have_mouse(false);
  pointer.turn({1, 0, 0});
  settle(pointer);
  EXPECT_LT(norm(rotation_between_rad(*pointer.read().turn, wanted)), 1e-9) << "without the mouse the hand rests";
}

TEST(MouseHand, IsTurnedLessAgainstATorqueOnly) {
  const auto turned_rad = [](const Vec3& torque_nm) {
    MouseHand pointer({.largest_torque_nm = 0.2});
    pointer.write({}, torque_nm);
    pointer.turn({0.4, 0, 0});
    settle(pointer);
    return rotation_rad(*pointer.read().turn).x;
  };
  EXPECT_NEAR(turned_rad({}), 0.4, 1e-9);
  EXPECT_NEAR(turned_rad({0.1, 0, 0}), 0.4, 1e-9) << "along";
  EXPECT_NEAR(turned_rad({0, 0.1, 0}), 0.4, 1e-9) << "across";
  EXPECT_NEAR(turned_rad({-0.1, 0, 0}), 0.2, 1e-9) << "half of the largest: half of the turn";
  EXPECT_NEAR(turned_rad({-0.2, 0, 0}), 0.0, 1e-9) << "the largest";
}

TEST(MouseHand, LosesNoMotionBetweenTwoThreads) {
  MouseHand pointer;
  std::thread window([&] {
    for (int n = 0; n < 100000; ++n) pointer.move({1e-6, 0, 0});
  });
  for (int n = 0; n < 1000; ++n) pointer.pass(1e-4);
  window.join();
  EXPECT_NEAR(place_m(pointer).x, 0.1, 1e-9);
}

}  // namespace pointer_test
}  // namespace palpa
