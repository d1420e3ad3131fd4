// Orientation by the grip of an Inverse3: its slow readings, its loss, and messages that give none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "palpa/device/grip_turn.h"
#include "palpa/device/inverse3_messages.h"
#include "tests/devices/inverse3_fixture.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace inverse3_grip_test {

using std::chrono::milliseconds;
using test::Clock;
using test::Inverse3;
using test::message_of;
using test::Random;

double angle_rad(const Turn& a, const Turn& b) { return norm(rotation_between_rad(a, b)); }

// ---- in simulated time ----

TEST(GripTurn, WalksToEachReadingOverOnePeriodWithoutAJump) {
  for (const double rate_hz : {20.0, 50.0, 100.0, 200.0}) {
    for (const double tick_s : {1e-3, 2.5e-4}) {
      GripTurn grip;
      const double turning_rad_per_s = 3.0;
      Turn last;
      for (int tick = 0; tick * tick_s < 3.0; ++tick) {
        const double time_s = tick * tick_s, read_s = std::floor(time_s * rate_hz + 1e-9) / rate_hz;
        Turn reading = turn_by({0, turning_rad_per_s * read_s, 0});
        // Either of the two quaternions of a rotation.
        if (static_cast<int>(read_s * rate_hz) % 3 == 0) reading = {-reading.w, -reading.x, -reading.y, -reading.z};
        const Turn turn = grip.at(time_s, reading);
        ASSERT_TRUE(is_unit(turn, 1e-12));
        if (time_s > 1.0) {
          ASSERT_LE(angle_rad(last, turn), 1.05 * turning_rad_per_s * tick_s) << rate_hz;
          // Late by a period.
          const Turn due = turn_by({0, turning_rad_per_s * (time_s - 1.0 / rate_hz), 0});
          ASSERT_LE(angle_rad(turn, due), 0.05 * turning_rad_per_s / rate_hz) << rate_hz;
        }
        last = turn;
      }
    }
  }
}

TEST(GripTurn, NeverStepsFurtherThanItsReadingsWhateverTheirTimes) {
  Random random(7);
  for (int run = 0; run < 50; ++run) {
    GripTurn grip;
    Turn reading = turn_by(random.in_cube(2.0)), last = reading;
    double time_s = random.uniform(0.0, 100.0), next_s = time_s;
    for (int tick = 0; tick < 2000; ++tick) {
      time_s += random.uniform(0.0, 2e-3);
      if (time_s >= next_s) {
        reading = turned_further(reading, random.in_cube(0.1));
        next_s = time_s + random.uniform(1e-3, 0.3);
      }
      const Turn turn = grip.at(time_s, reading);
      if (tick > 0) {
        ASSERT_LE(angle_rad(last, turn), angle_rad(last, reading) + 1e-9) << "it goes there straight";
      }
      last = turn;
    }
    for (int tick = 0; tick < 200; ++tick) last = grip.at(time_s += 1e-3, reading);
    EXPECT_LT(angle_rad(last, reading), 1e-9) << "and arrives";
    grip.reset();
    const Turn other = turn_by(random.in_cube(2.0));
    EXPECT_EQ(grip.at(time_s, other), other) << "after a gap at once";
  }
}

// ---- messages ----

TEST(Inverse3Messages, TurnAGripsQuaternionIntoTheHandsAxes) {
  const auto turn_of_text = [](const std::string& orientation) {
    inverse3::ServiceView view;
    const bool is_read = inverse3::read_message(
        R"({"wireless_verse_grip":[{"device_id":"7","state":{"orientation":)" + orientation + R"(}}]})", "", view);
    EXPECT_TRUE(is_read) << orientation;
    return view.grips.at(0).turn;
  };
  EXPECT_EQ(turn_of_text(R"({"w":1,"x":0,"y":0,"z":0})"), Turn{});
  // A quarter turn about the service's axis away from the user.
  const double half = std::sqrt(0.5);
  const auto turn = turn_of_text(R"({"w":0.7071067811865476,"x":0,"y":0.7071067811865476,"z":0})");
  ASSERT_TRUE(turn);
  EXPECT_LT(angle_rad(*turn, {half, 0, 0, -half}), 1e-12);
  EXPECT_FALSE(turn_of_text(R"({"w":0,"x":0,"y":0,"z":0})")) << "not known yet";
  EXPECT_FALSE(turn_of_text(R"({"w":1,"x":1,"y":0,"z":0})")) << "no rotation";
  for (const char* wrong :
       {R"({"w":1,"x":0,"y":0})", R"({"w":"1","x":0,"y":0,"z":0})", "[1,0,0,0]", R"({"w":1e300,"x":0,"y":0,"z":0})"}) {
    inverse3::ServiceView view;
    EXPECT_FALSE(inverse3::read_message(
        R"({"verse_grip":[{"device_id":"7","state":{"orientation":)" + std::string(wrong) + "}}]}", "", view))
        << wrong;
  }
}

// ---- on the stand-in ----

TEST_F(Inverse3, SensesTheTurnOfItsGripAndDrivesNoTorque) {
  const auto device = open();
  EXPECT_TRUE(device->limits().senses_turn);
  EXPECT_EQ(device->limits().max_torque_nm, 0.0);
  EXPECT_TRUE(comes(*device, {}, [&] { return state.turn == Turn{}; }));
}

TEST_F(Inverse3, WithoutAGripSensesNoTurn) {
  service.connect_grip(false);
  const auto device = open();
  EXPECT_FALSE(device->limits().senses_turn);
  EXPECT_TRUE(comes(*device, {}, [&] { return state.valid && !state.turn && state.fault == nullptr; }));
}

TEST_F(Inverse3, KeepsItsTurnWithAFaultWhereTheGripThatWasTurnedHasLeft) {
  for (const bool is_told : {true, false}) {
    const auto leaves = [&](bool gone) { is_told ? service.tell_grip_is_gone(gone) : service.connect_grip(!gone); };
    service.turn_grip({});
    std::this_thread::sleep_for(milliseconds(30));  // until the grip shows it
    const auto device = open();
    EXPECT_TRUE(comes(*device, {}, [&] { return state.valid && state.fault == nullptr; }));
    // A grip that lies beside the device may leave.
    leaves(true);
    for (int n = 0; n < 100; ++n) {
      EXPECT_TRUE(comes(*device, {}, [&] { return state.valid; }));
      ASSERT_EQ(state.fault, nullptr);
      ASSERT_EQ(state.turn, Turn{});
    }
    leaves(false);
    const Turn turned = turn_by({0, 0, 0.5});
    service.turn_grip({turned.w, turned.x, -turned.z, turned.y});
    EXPECT_TRUE(comes(*device, {0.5, 0, 0}, [&] { return state.turn && angle_rad(*state.turn, turned) < 1e-9; }));
    leaves(true);
    EXPECT_TRUE(comes(*device, {0.5, 0, 0}, [&] { return state.fault != nullptr && felt_n() == Vec3{}; }));
    EXPECT_TRUE(state.valid) << "the arm has its position";
    EXPECT_LT(angle_rad(*state.turn, turned), 1e-9) << "the last known";
    leaves(false);
    EXPECT_TRUE(is_felt(*device, {0.5, 0, 0}));
  }
}

TEST_F(Inverse3, TakesTheGripThatItIsTold) {
  service.turn_grip({std::cos(0.2), std::sin(0.2), 0, 0});
  const auto device = open({{"grip", "65280"}});
  EXPECT_TRUE(comes(*device, {}, [&] { return state.turn && angle_rad(*state.turn, turn_by({0.4, 0, 0})) < 1e-9; }));
  EXPECT_NE(message_of([&] { open({{"grip", "4711"}}); }).find("grip=4711"), std::string::npos);
  EXPECT_FALSE(open({{"grip", "61548"}})->limits().senses_turn) << "the wired one has no orientation";
}

}  // namespace inverse3_grip_test
}  // namespace palpa
