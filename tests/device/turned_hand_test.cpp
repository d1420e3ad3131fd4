// Hands with an orientation: swinging simulated ones, recorded quaternions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "palpa/base/load_error.h"
#include "palpa/device/hand.h"

namespace palpa {
namespace turned_hand_test {

namespace fs = std::filesystem;
using testing::EndsWith;
using testing::HasSubstr;

double angle_rad(const Turn& from, const Turn& to) { return norm(rotation_between_rad(from, to)); }

class TurnedHand : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "palpa-turned-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
  }
  void TearDown() override { fs::remove_all(root_); }
  std::unique_ptr<Target> open(const std::string& text, const RecordingOptions& options = {.center = false}) const {
    std::ofstream(root_ / "hand.csv", std::ios::binary) << text;
    return recorded_target(root_ / "hand.csv", options);
  }
  std::string error(const std::string& text, const RecordingOptions& options = {}) const {
    try {
      open(text, options);
    } catch (const LoadError& refused) {
      return refused.what();
    }
    return "(no error)";
  }

 private:
  fs::path root_;
};

constexpr const char* quarter =
    "t_s,x_m,y_m,z_m,turn_w,turn_x,turn_y,turn_z\n"
    "0,0,0,0,1,0,0,0\n0.08,0,0,0.01,0.7071068,0,0,0.7071068\n0.16,0,0,0.02,0.7071068,0,0,0.7071068\n";

TEST_F(TurnedHand, BetweenRowsTheHandleTurnsEvenly) {
  const auto hand = open(quarter);
  for (const double share : {0.0, 0.1, 0.25, 0.5, 0.9, 1.0}) {
    const Turn turn = *hand->at(0.08 * share).turn;
    EXPECT_NEAR(angle_rad(turn, turn_by({0, 0, share * std::acos(0.0)})), 0.0, 1e-7) << share;
    EXPECT_TRUE(is_unit(turn, 1e-15));
  }
  EXPECT_EQ(*hand->at(0.12).turn, *hand->at(0.08).turn) << "it rests";
  EXPECT_EQ(*hand->at(1.0).turn, *hand->at(0.16).turn) << "the last known one";
  EXPECT_FALSE(open("t_s,x_m,y_m,z_m\n0,0,0,0\n1,0,0,0\n")->at(0).turn.has_value());
}

TEST_F(TurnedHand, AQuaternionAndItsNegativeAreOneOrientation) {
  const auto hand =
      open("t_s,x_m,y_m,z_m,turn_w,turn_x,turn_y,turn_z\n0,0,0,0,1,0,0,0\n0.05,0,0,0,-0.9950042,-0.0998334,0,0\n");
  for (int n = 0; n <= 10; ++n)
    EXPECT_NEAR(angle_rad({}, *hand->at(0.005 * n).turn), 0.02 * n, 1e-6) << "by the shorter way, 0.2 rad";
}

TEST_F(TurnedHand, EveryFormButHaplysHasThem) {
  EXPECT_EQ(*open("turn_z,turn_w,turn_x,turn_y,time,x,y,z\n1,0,0,0,0,0,0,0\n")->at(0).turn, (Turn{0, 0, 0, 1}));
  EXPECT_EQ(*open("x,y,z,turn_w,turn_x,turn_y,turn_z\n0,0,0,0,1,0,0\n", {.hand_rate_hz = 100})->at(0).turn, (Turn{0, 1, 0, 0}));
  EXPECT_EQ(open("Time,Cursor Position X,Cursor Position Y,Cursor Position Z,turn_w,turn_x,turn_y,turn_z\n0,1,1,1,0,1,0,0\n")
                ->at(0)
                .turn,
            std::nullopt);
}

TEST_F(TurnedHand, OurOwnTicksGiveBackEveryTurnToTheBit) {
  const Turn third = turn_by({0.1, -0.7, 1.0 / 3.0}), other = turn_by({2.0, 1e-3, 0.0});
  char text[1024];
  std::snprintf(text, sizeof text,
                "t_s,probe_x_m,probe_y_m,probe_z_m,probe_valid,buttons,probe_turn_w,probe_turn_x,probe_turn_y,probe_turn_z\n"
                "0,0,0,0,1,0,%.17g,%.17g,%.17g,%.17g\n0.001,nan,0,0,0,0,0,0,0,0\n0.002,0,0,0,1,0,%.17g,%.17g,%.17g,%.17g\n",
                third.w, third.x, third.y, third.z, other.w, other.x, other.y, other.z);
  const auto hand = open(text);
  EXPECT_EQ(*hand->at(0.0).turn, third);
  EXPECT_FALSE(hand->at(0.001).valid);
  EXPECT_EQ(*hand->at(0.001).turn, third) << "the last known one";
  EXPECT_EQ(*hand->at(0.002).turn, other);
}

TEST_F(TurnedHand, ATurnOfAnotherLengthIsRefusedWithItsLine) {
  const std::string header = "t_s,x_m,y_m,z_m,turn_w,turn_x,turn_y,turn_z\n0,0,0,0,1,0,0,0\n";
  for (const char* wrong : {"0,0,0,0", "1,0.1,0,0", "0.998,0,0,0", "nan,0,0,0", "inf,0,0,0"}) {
    EXPECT_THAT(error(header + "0.1,0,0,0," + wrong + "\n"), HasSubstr("hand.csv:3: the orientation is no unit quaternion; "))
        << wrong;
  }
  EXPECT_THAT(error(header + "0.1,0,0,0,high,0,0,0\n"), HasSubstr("hand.csv:3: 'high' is no number; "));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m,turn_w,turn_x,turn_z\n0,0,0,0,1,0,0\n"),
              HasSubstr("hand.csv:1: has a part of an orientation; a quaternion has the columns turn_w, turn_x, turn_y and "));
  EXPECT_TRUE(is_unit(*open(header + "0.1,0,0,0,0.9995,0,0,0\n")->at(0.1).turn, 1e-15)) << "rounded digits";
}

TEST_F(TurnedHand, RowsThatOnlyTurnAreNoRepeats) {
  std::string text = "t_s,x_m,y_m,z_m,turn_w,turn_x,turn_y,turn_z\n";
  for (int n = 0; n < 400; ++n) {
    char row[128];
    const double angle = 0.001 * n;
    std::snprintf(row, sizeof row, "%.3f,%.4f,0,0,%.9f,0,0,%.9f\n", 0.001 * n, 0.001 * (n / 4), std::cos(angle),
                  std::sin(angle));
    text += row;
  }
  const auto hand = open(text);
  EXPECT_THAT(hand->warnings(), testing::IsEmpty());
  for (int n = 0; n < 399; ++n) EXPECT_NEAR(angle_rad({}, *hand->at(0.001 * n).turn), 0.002 * n, 1e-6) << n;
}

TEST_F(TurnedHand, PlacementLeavesItsTurn) {
  const std::shared_ptr<const Target> hand = open(quarter);
  EXPECT_EQ(displaced(hand, {1, 2, 3}, 0.5)->at(0.05).turn, hand->at(0.05).turn);
}

// ---- simulated ----

TEST(TiltedHand, HasNoOrientationUnlessSaid) {
  EXPECT_EQ(simulated_target("sim:press")->at(1.0).turn, std::nullopt);
  const auto device = open_hand("sim:press", std::nullopt);
  EXPECT_EQ(device->read().turn, std::nullopt);
  EXPECT_FALSE(device->limits().senses_turn);
  EXPECT_EQ(device->limits().max_torque_nm, 0.0);
}

TEST(TiltedHand, SwingsSmoothlyAboutXAndZByItsAmplitude) {
  constexpr double tilt = 0.4, dt = 1e-3;
  const auto hand = simulated_target("sim:stroke,tilt_rad=0.4"), plain = simulated_target("sim:stroke");
  EXPECT_EQ(*hand->at(0.0).turn, Turn{}) << "it begins upright";
  double largest_x = 0.0, largest_z = 0.0;
  for (int n = 0; n < 16000; ++n) {
    const Target::Point point = hand->at(dt * n);
    EXPECT_EQ(point.position_m, plain->at(dt * n).position_m);
    ASSERT_TRUE(is_unit(*point.turn, 1e-15));
    // First about x, then about z: the images of the axes give both angles.
    const Vec3 x = rotated(*point.turn, {1, 0, 0}), z = rotated(*point.turn, {0, 0, 1});
    EXPECT_NEAR(x.z, 0.0, 1e-15);
    largest_z = std::max(largest_z, std::abs(std::atan2(x.y, x.x)));
    largest_x = std::max(largest_x, std::acos(std::min(1.0, z.z)));
    const double speed = angle_rad(*point.turn, *hand->at(dt * (n + 1)).turn) / dt;
    EXPECT_LE(speed, 2 * 3.1416 * std::hypot(0.5, 0.3125) * tilt);
  }
  EXPECT_NEAR(largest_x, tilt, 1e-5);
  EXPECT_NEAR(largest_z, tilt, 1e-5);
}

TEST(TiltedHand, IsReadByADeviceThatTurnsItFreely) {
  const auto device = open_hand("sim:press,tilt_rad=0.3", std::nullopt);
  const auto target = simulated_target("sim:press,tilt_rad=0.3");
  EXPECT_TRUE(device->limits().senses_turn);
  EXPECT_EQ(device->limits().max_torque_nm, 1.0);
  SimulatedDevice& hand = *device;
  for (int n = 1; n <= 100; ++n) {
    static_cast<Device&>(hand).write({}, {1.0, 1.0, 1.0});
    hand.advance(1e-3);
    EXPECT_NEAR(angle_rad(*hand.read().turn, *target->at(1e-3 * n).turn), 0.0, 1e-12) << "no torque turns it";
  }
  EXPECT_EQ(open_hand("sim:press,tilt_rad=0.3", Hold::rigid, {}, device_plant("touch"))->limits().max_torque_nm, 0.0);
  EXPECT_EQ(
      open_hand("sim:press,tilt_rad=0.3", Hold::rigid, {}, device_plant("omega,max_torque_nm=0.4"))->limits().max_torque_nm,
      0.4);
}

TEST(TiltedHand, AWrongTiltIsRefused) {
  for (const char* wrong : {"0", "-1", "3.5", "nan", "much"}) {
    try {
      simulated_motion(std::string("sim:press,tilt_rad=") + wrong);
      ADD_FAILURE() << wrong;
    } catch (const LoadError& error) {
      EXPECT_THAT(error.what(),
                  EndsWith("cannot be used for tilt_rad; it is a number of radians above 0, at most 3, as in 0.3"));
    }
  }
}

}  // namespace turned_hand_test
}  // namespace palpa
