// Requirements of every device kind (rig.h): axes, steps and torques of a handle that turns.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <thread>

#include "tests/devices/every_device.h"

namespace palpa {
namespace conformance_test {

double angle_rad(const Turn& a, const Turn& b) { return norm(rotation_between_rad(a, b)); }

TEST_P(EveryDevice, HasItsHandleTurnedAsTheHandSeesIt) {
  const auto device = rig->open();
  EXPECT_TRUE(works(*device));
  EXPECT_EQ(device->limits().senses_turn, rig->wrist() != Rig::Wrist::none);
  EXPECT_EQ(state.turn.has_value(), device->limits().senses_turn);
  if (rig->wrist() == Rig::Wrist::none) return;
  EXPECT_LT(angle_rad(*state.turn, {}), 1e-9) << "no turn in the reference pose";
  for (const Vec3& turn_rad : {Vec3{0.5, 0, 0}, Vec3{0, 0.6, 0}, Vec3{0, 0, 0.7}, Vec3{1.5, -1.2, 0.9}, Vec3{-0.3, 0.2, 2.5}}) {
    const Turn turn = turn_by(turn_rad);
    rig->turn(turn);
    EXPECT_TRUE(comes(*device, {},
                      [&] {
                        EXPECT_TRUE(state.turn && is_unit(*state.turn, 1e-9));
                        return state.valid && angle_rad(*state.turn, turn) < 1e-6;
                      }))
        << turn_rad.x << ' ' << turn_rad.y << ' ' << turn_rad.z;
  }
}

// A slow grip too: hardly any step is far above that of the handle in the same time, as each of its 50 readings a second would
// be. A paused machine delivers a few late.
TEST_P(EveryDevice, TurnsWithoutJumps) {
  if (rig->wrist() == Rig::Wrist::none) return;
  const auto device = rig->open();
  EXPECT_TRUE(works(*device));
  constexpr double turning_rad_per_s = 2.0, duration_s = 1.0;
  const auto begin = Clock::now();
  const auto passed_s = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  Turn last = *state.turn;
  const double jump_rad = 0.25 * turning_rad_per_s / std::min(200.0, rig->turn_rate_hz());
  double last_s = 0.0, turned_rad = 0.0;
  int looks = 0, jumps = 0;
  for (double now_s = 0.0; now_s < duration_s; now_s = passed_s()) {
    rig->turn(turn_by({0, turning_rad_per_s * now_s, 0}));
    device->write({});
    std::this_thread::sleep_for(milliseconds(1));
    state = device->read();
    ASSERT_TRUE(state.turn && is_unit(*state.turn, 1e-9));
    const double step_rad = angle_rad(last, *state.turn), step_s = passed_s() - last_s;
    // Beyond twice the handle's own turn since the last look.
    jumps += step_rad - 2.0 * turning_rad_per_s * (step_s + 0.002) > jump_rad;
    ++looks;
    turned_rad += step_rad;
    last = *state.turn;
    last_s += step_s;
  }
  EXPECT_LE(jumps, 0.02 * looks);
  EXPECT_NEAR(turned_rad, turning_rad_per_s * duration_s, 0.4);
}

TEST_P(DeviceWithMotors, DrivesATorqueAboutTheAxesThatItIsTold) {
  const auto device = rig->open();
  EXPECT_TRUE(works(*device));
  const double most_nm = device->limits().max_torque_nm;
  EXPECT_EQ(most_nm > 0.0, rig->wrist() == Rig::Wrist::driven);
  const Vec3 force_n{0.1, 0.2, 0.3};
  const auto drives = [&](const Vec3& asked_nm, const Vec3& made_nm) {
    for (const auto end = Clock::now() + patience; Clock::now() < end;) {
      if (!device->write(force_n, asked_nm)) return false;
      std::this_thread::sleep_for(milliseconds(1));
      state = device->read();
      if (distance(rig->torque_nm(), made_nm) < 1e-9 && distance(rig->force_n(), force_n) < force_step_n) return true;
    }
    return false;
  };
  for (const Vec3& torque_nm : {Vec3{0.05, 0, 0}, Vec3{0, 0.06, 0}, Vec3{0, 0, 0.07}, Vec3{-0.03, 0.02, -0.01}}) {
    EXPECT_TRUE(drives(torque_nm, most_nm > 0.0 ? torque_nm : Vec3{})) << "a device without drives the force alone";
    EXPECT_EQ(state.fault, nullptr);
  }
  EXPECT_TRUE(drives({0, 30, 40}, {0, 0.6 * most_nm, 0.8 * most_nm}));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(comes(*device, force_n, [&] { return rig->torque_nm() == Vec3{}; })) << "a force alone has no torque";
  if (most_nm > 0.0) {
    EXPECT_TRUE(drives({0.05, 0, 0}, {0.05, 0, 0}));
    for (const auto end = Clock::now() + patience; rig->torque_nm() != Vec3{} && Clock::now() < end;) {
      device->write(force_n, {0, nan, 0});
      std::this_thread::sleep_for(milliseconds(1));
    }
    EXPECT_EQ(rig->torque_nm(), Vec3{}) << "what is not finite is zero";
    EXPECT_EQ(rig->force_n(), Vec3{});
    EXPECT_TRUE(drives({0.05, 0, 0}, {0.05, 0, 0}));
    EXPECT_FALSE(device->rests());
    device->write({});
    for (const auto end = Clock::now() + patience; !device->rests() && Clock::now() < end;) std::this_thread::yield();
    EXPECT_EQ(rig->torque_nm(), Vec3{}) << "at rest";
    EXPECT_TRUE(drives({0.05, 0, 0}, {0.05, 0, 0}));
  }
  rig->unplug();
  EXPECT_EQ(rig->torque_nm(), Vec3{});
}

}  // namespace conformance_test
}  // namespace palpa
