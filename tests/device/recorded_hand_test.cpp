// Recorded hands: forms, interpolation, gaps, refusals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>

#include "palpa/base/load_error.h"
#include "palpa/device/hand.h"
#include "tests/shared_data.h"

namespace palpa {
namespace recorded_hand_test {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class RecordedHand : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "palpa-hand-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path file(const std::string& text) const {
    std::ofstream(root_ / "hand.csv", std::ios::binary) << text;
    return root_ / "hand.csv";
  }
  std::unique_ptr<Target> open(const std::string& text, const RecordingOptions& options = {.center = false}) const {
    return recorded_target(file(text), options);
  }
  std::string error(const std::string& text, const RecordingOptions& options = {}) const {
    try {
      recorded_target(file(text), options);
    } catch (const LoadError& refused) {
      return refused.what();
    }
    return "(no error)";
  }
  const fs::path& root() const { return root_; }

 private:
  fs::path root_;
};

// ---- the four forms ----

TEST_F(RecordedHand, PlainColumnsInAnyOrder) {
  const auto hand = open("buttons,t_s, y_m ,x_m,z_m,other\n0,5,2,1,3,9\n3,5.05,2.5,1,3,9\n");
  EXPECT_EQ(hand->at(0).position_m, (Vec3{1, 2, 3}));
  EXPECT_EQ(hand->at(0.05).position_m, (Vec3{1, 2.5, 3}));
  EXPECT_EQ(hand->at(0.049).buttons, 0u);
  EXPECT_EQ(hand->at(0.05).buttons, 3u);
  EXPECT_NEAR(hand->duration_s(), 0.05, 1e-15);
}

TEST_F(RecordedHand, HaplyLogsAreFlippedAndTheirZeroRowsAndVelocitiesIgnored) {
  const auto hand = open(
      "Frame,Time,Cursor Position X,Cursor Position Y,Cursor Position Z,Cursor Velocity X,Cursor Velocity Y,Cursor Velocity "
      "Z\r\n"
      "1,10,0,0,0,0,0,0\r\n2,10,1,2,-3,99,99,99\r\n3,10.02,1,2,-4,99,99,99\r\n");
  EXPECT_EQ(hand->at(0).position_m, (Vec3{1, 2, 3}));
  EXPECT_NEAR(hand->duration_s(), 0.02, 1e-12);
  EXPECT_NEAR(hand->at(0.01).position_m.z, 3.5, 1e-9);
}

TEST_F(RecordedHand, WithoutTimeTheRateSaysIt) {
  const auto hand = open("x,y,z,q0\n0,0,0,1\n1,0,0,1\n3,0,0,1\n", {.hand_rate_hz = 20, .center = false});
  EXPECT_EQ(hand->duration_s(), 0.1);
  EXPECT_EQ(hand->at(0.05).position_m.x, 1);
}

TEST_F(RecordedHand, NamesWithoutUnitsAreSecondsAndMetres) {
  const std::string rows = "0,1,2,3\n0.05,1,2.5,3\n";
  for (const char* names : {"time,x,y,z\n", "t,x,y,z\n", "timestamp,x_m,y_m,z_m\n", "time_s,x,y,z\n", "t_s,x,y,z\n"}) {
    const auto hand = open(names + rows);
    EXPECT_EQ(hand->at(0.05).position_m, (Vec3{1, 2.5, 3})) << names;
    EXPECT_EQ(hand->duration_s(), 0.05) << names;
  }
  EXPECT_EQ(open("time,x,y,z\n" + rows, {.hand_rate_hz = 100, .center = false})->duration_s(), 0.01) << "a rate goes first";
  EXPECT_THAT(error("time,x,y,z\n0,1,2,3\n10,1,2,3\n20,1,2,3\n"), HasSubstr("10 s apart; 'time' is in seconds"));
  EXPECT_THAT(error("time,x,y,z\n0,1,2,3\n0.01,251,2,3\n"), HasSubstr("over 250 m; 'x' is in metres"));
  EXPECT_EQ(open("t_s,x,y,z\n0,1,2,3\n10,1,2,3\n")->duration_s(), 10) << "the name says seconds";
}

TEST_F(RecordedHand, OurOwnTicksGiveBackEverySampleToTheBitAndTheirValidity) {
  // Irregular values at the times of a 3 kHz clock, with repeated times.
  std::string text = "tick,t_s,probe_x_m,probe_y_m,probe_z_m,probe_valid,buttons\n";
  std::vector<double> x;
  char row[200];
  for (int i = 0; i < 300; ++i) {
    x.push_back(0.05 * std::sin(i / 7 * 0.9));
    std::snprintf(row, sizeof row, "%d,%.17g,%.17g,0.01,-0.02,%d,%d\n", i, i / 3000.0, x.back(), i != 100, i % 2);
    text += row;
  }
  const auto hand = open(text, {});
  for (int i = 0; i < 300; ++i) {
    const Target::Point point = hand->at(i / 3000.0);
    EXPECT_EQ(point.valid, i != 100);
    EXPECT_EQ(point.buttons, i % 2);
    if (point.valid) {
      EXPECT_EQ(point.position_m, (Vec3{x[i], 0.01, -0.02}));
    }
  }
  EXPECT_FALSE(hand->at(99.5 / 3000).valid);
  EXPECT_FALSE(hand->at(100.5 / 3000).valid);
  EXPECT_TRUE(hand->at(101.5 / 3000).valid);
}

TEST_F(RecordedHand, OurOwnTicksMayHoldProbesThatAreNoNumbers) {
  const auto hand = open(
      "t_s,probe_x_m,probe_y_m,probe_z_m,probe_valid\n0,1,2,3,1\n0.001,nan,-inf,0,1\n0.002,1e300,0,0,0\n0.003,1,2,4,1\n", {});
  for (double t = -0.001; t < 0.01; t += 0.0005) EXPECT_TRUE(is_finite(hand->at(t).position_m));
  EXPECT_FALSE(hand->at(0.001).valid);
  EXPECT_FALSE(hand->at(0.002).valid);
  EXPECT_TRUE(hand->at(0.003).valid);
}

// ---- centring ----

TEST_F(RecordedHand, TheMiddleOfItsBoxIsTheMiddleOfTheWorkspaceUnlessItIsOurs) {
  const std::string rows = "0,1,5,-2,1\n0.01,3,4,-2,1\n0.02,2,9,-6,1\n";
  const std::string plain = "t_s,x_m,y_m,z_m,more\n" + rows;
  const std::string ours = "t_s,probe_x_m,probe_y_m,probe_z_m,probe_valid\n" + rows;
  EXPECT_EQ(open(plain, {})->at(0).position_m, (Vec3{-1, -1.5, 2}));
  EXPECT_EQ(open(plain, {.center = false})->at(0).position_m, (Vec3{1, 5, -2}));
  EXPECT_EQ(open(ours, {})->at(0).position_m, (Vec3{1, 5, -2}));
  EXPECT_EQ(open(ours, {.center = true})->at(0).position_m, (Vec3{-1, -1.5, 2}));
}

// ---- between the rows ----

TEST_F(RecordedHand, TheCubicGoesThroughItsRowsAndStaysBetweenNeighbours) {
  std::mt19937 engine(3);
  std::string text = "t_s,x_m,y_m,z_m\n";
  std::vector<double> t, x;
  char row[200];
  double time = 0;
  for (int i = 0; i < 500; ++i) {
    t.push_back(time);
    // Steps from tiny to large, turning points, plateaus.
    const int kind = static_cast<int>(engine() % 4);
    const double step = kind == 0 ? 0.0 : kind == 1 ? 1e-12 : (static_cast<double>(engine() % 1000) - 500) * 1e-4;
    x.push_back((x.empty() ? 0.0 : x.back()) + step);
    std::snprintf(row, sizeof row, "%.17g,%.17g,%.17g,0\n", t.back(), x.back(), static_cast<double>(i));
    text += row;
    time += 1e-6 + 0.02 * static_cast<double>(engine() % 1000) / 1000;
  }
  const auto hand = open(text);
  for (std::size_t i = 0; i + 1 < t.size(); ++i) {
    EXPECT_EQ(hand->at(t[i]).position_m.x, x[i]);
    double last = x[i];
    for (int j = 1; j < 50; ++j) {
      const double now = hand->at(t[i] + (t[i + 1] - t[i]) * j / 50).position_m.x;
      EXPECT_GE(now, std::min(x[i], x[i + 1]));
      EXPECT_LE(now, std::max(x[i], x[i + 1]));
      EXPECT_GE((now - last) * (x[i + 1] - x[i]), -1e-16);
      last = now;
    }
  }
}

TEST_F(RecordedHand, AStraightMotionStaysStraight) {
  std::string text = "t_s,x_m,y_m,z_m\n";
  for (const char* row : {"0,0,0,0\n", "0.01,0.01,-0.02,0.03\n", "0.05,0.05,-0.1,0.15\n", "0.07,0.07,-0.14,0.21\n"})
    text += row;
  const auto hand = open(text);
  for (double t = 0; t <= 0.07; t += 0.001) EXPECT_NEAR(distance(hand->at(t).position_m, {t, -2 * t, 3 * t}), 0, 1e-16);
}

TEST_F(RecordedHand, ASmoothMotionIsMetToSecondOrder) {
  // Halving the distance of rows divides the error by at least 3 where the motion does not turn.
  double last_error = 0;
  for (int n : {50, 100, 200}) {
    std::string text = "t_s,x_m,y_m,z_m\n";
    char row[100];
    for (int i = 0; i <= n; ++i) {
      std::snprintf(row, sizeof row, "%.17g,%.17g,0,0\n", static_cast<double>(i) / n, std::exp(static_cast<double>(i) / n));
      text += row;
    }
    const auto hand = open(text);
    double error = 0;
    for (double t = 0.1; t < 0.9; t += 0.0007) error = std::max(error, std::abs(hand->at(t).position_m.x - std::exp(t)));
    if (last_error > 0) {
      EXPECT_LT(error, last_error / 3);
    }
    last_error = error;
  }
}

TEST_F(RecordedHand, AGapOfMoreThan100MsIsNotValid) {
  const auto hand = open("t_s,x_m,y_m,z_m\n0,0,0,0\n0.125,1,0,0\n0.2,2,0,0\n");
  EXPECT_TRUE(hand->at(0).valid);
  EXPECT_FALSE(hand->at(0.001).valid);
  EXPECT_FALSE(hand->at(0.124).valid);
  EXPECT_EQ(hand->at(0.1).position_m.x, 0);
  for (double t = 0.125; t <= 0.2; t += 0.005) EXPECT_TRUE(hand->at(t).valid);
  EXPECT_FALSE(hand->at(0.25).valid);
  EXPECT_FALSE(hand->at(-1).valid);
}

TEST_F(RecordedHand, GapsAreTold) {
  EXPECT_TRUE(open("t_s,x_m,y_m,z_m\n0,0,0,0\n0.1,1,0,0\n0.2,2,0,0\n")->warnings().empty());
  const auto told = open("t_s,x_m,y_m,z_m\n0,0,0,0\n0.1,1,0,0\n1.1,2,0,0\n1.2,2,0,0\n2.2,3,0,0\n")->warnings();
  ASSERT_EQ(told.size(), 1u);
  EXPECT_THAT(told[0], AllOf(HasSubstr("for 2 of 2.2 s"), HasSubstr("first after 0.1 s"), HasSubstr("more than 100 ms apart")));
}

TEST_F(RecordedHand, ARowWithoutAPositionIsAGap) {
  const auto hand = open("t_s,x_m,y_m,z_m\n0,0,0,0\n0.05,nan,0,0\n0.09,1,0,0\n0.15,inf,nan,nan\n0.2,2,0,0\n");
  EXPECT_TRUE(hand->at(0.05).valid);
  EXPECT_FALSE(hand->at(0.15).valid);
  for (double t = 0; t < 0.3; t += 0.001) EXPECT_TRUE(is_finite(hand->at(t).position_m));
}

TEST_F(RecordedHand, RowsThatRepeatTheLastPositionAreDropped) {
  // A logger twice as fast as its device: a steady motion in pairs of rows; steady without the repeats.
  std::string text = "t_s,x_m,y_m,z_m\n";
  for (int i = 0; i < 40; ++i) text += std::to_string(i * 0.005) + "," + std::to_string(i / 2 * 0.01) + ",0,0\n";
  const auto hand = open(text);
  for (double t = 0; t < 0.175; t += 0.001) EXPECT_NEAR(hand->at(t).position_m.x, t, 1e-9);
  EXPECT_NEAR(hand->duration_s(), 0.195, 1e-12);
}

TEST_F(RecordedHand, AtAHapticRateTheStepsOfAnEncoderStay) {
  // A slow motion in steps of 55 µm at 1 kHz: device and recording rest in most ticks.
  std::string text = "t_s,x_m,y_m,z_m\n";
  std::vector<double> x_m;
  char row[100];
  for (int i = 0; i < 500; ++i) {
    x_m.push_back(std::round(0.01 * i * 1e-3 / 55e-6) * 55e-6);
    std::snprintf(row, sizeof row, "%.17g,%.17g,0,0\n", i * 1e-3, x_m.back());
    text += row;
  }
  const auto hand = open(text);
  for (int i = 0; i < 500; ++i) EXPECT_NEAR(hand->at(i * 1e-3).position_m.x, x_m[static_cast<std::size_t>(i)], 1e-15) << i;
}

/// A hand's motion by time, up to 0.14 m/s: strokes, presses with rests between them, a slow path without turns.
Vec3 moving_hand_m(int motion, double t) {
  switch (motion) {
    case 0: return {0.03 * std::sin(4.4 * t), 0.01 * std::sin(1.5 * t), 0.05 + 0.004 * std::sin(7.0 * t)};
    case 1: return {0.0, 0.0, 0.05 - 0.02 * std::max(0.0, std::sin(1.6 * t))};
    default: return {0.025 * t, 0.0, 0.05};
  }
}

/// Five seconds of a hand under a tracker of `tracker_hz`, in rows that repeat the latest position; tracker times are off by up
/// to `unevenness` of the period.
std::string logged(int motion, double tracker_hz, double rows_hz, double unevenness) {
  std::mt19937 engine(7);
  std::vector<double> times_s;
  for (int k = 0; k < 5 * tracker_hz + 2; ++k)
    times_s.push_back((k + unevenness * (static_cast<double>(engine() % 1000) / 1000 - 0.5)) / tracker_hz);
  std::string text = "t_s,x_m,y_m,z_m\n";
  std::size_t latest = 0;
  char row[120];
  for (int n = 0; n < 5 * rows_hz; ++n) {
    while (latest + 1 < times_s.size() && times_s[latest + 1] <= n / rows_hz) ++latest;
    const Vec3 at_m = moving_hand_m(motion, std::max(0.0, times_s[latest]));
    std::snprintf(row, sizeof row, "%.6f,%.6f,%.6f,%.6f\n", n / rows_hz, at_m.x, at_m.y, at_m.z);
    text += row;
  }
  return text;
}

// At any two rates no step per tick is above twice the hand's own, as it would be with repeats taken for rest.
TEST_F(RecordedHand, ATrackersRepeatsAreLeftOutAtEveryRateOfRows) {
  for (const int motion : {0, 1, 2}) {
    for (const double tracker_hz : {30.0, 60.0, 90.0, 144.0}) {
      for (const double rows_hz : {200.0, 390.0, 400.0, 1000.0, 4000.0}) {
        for (const double unevenness : {0.0, 0.3}) {
          const auto hand = open(logged(motion, tracker_hz, rows_hz, unevenness));
          const double fastest_m_per_s = motion == 0 ? 0.14 : motion == 1 ? 0.032 : 0.025;
          double longest_m = 0.0;
          for (int n = 1; n < 4900; ++n)
            longest_m = std::max(longest_m, distance(hand->at(1e-3 * n).position_m, hand->at(1e-3 * (n - 1)).position_m));
          // A motion after a rest catches up the held-back distance, and uneven times are uneven speeds.
          EXPECT_LT(longest_m, (motion == 1 ? 3.5 : 2.5) * (1.0 + unevenness) * fastest_m_per_s * 1e-3)
              << "motion " << motion << ", " << tracker_hz << " Hz in " << rows_hz << " rows a second, uneven " << unevenness;
        }
      }
    }
  }
}

TEST_F(RecordedHand, AnEncodersStepsStayAtEveryHapticRate) {
  for (const int motion : {0, 1, 2}) {
    for (const double rows_hz : {500.0, 1000.0, 4000.0}) {
      for (const double step_m : {1e-5, 2.3e-5, 5.5e-5, 6e-5}) {
        std::string text = "t_s,x_m,y_m,z_m\n";
        std::vector<Vec3> rows_m;
        char row[160];
        for (int n = 0; n < 4 * rows_hz; ++n) {
          const Vec3 at_m = moving_hand_m(motion, n / rows_hz);
          rows_m.push_back({std::round(at_m.x / step_m) * step_m, std::round(at_m.y / step_m) * step_m,
                            std::round(at_m.z / step_m) * step_m});
          std::snprintf(row, sizeof row, "%.17g,%.17g,%.17g,%.17g\n", n / rows_hz, rows_m.back().x, rows_m.back().y,
                        rows_m.back().z);
          text += row;
        }
        const auto hand = open(text);
        double farthest_off_m = 0.0;
        for (std::size_t n = 0; n < rows_m.size(); ++n)
          farthest_off_m = std::max(farthest_off_m, distance(hand->at(static_cast<double>(n) / rows_hz).position_m, rows_m[n]));
        EXPECT_EQ(farthest_off_m, 0.0) << "motion " << motion << ", " << rows_hz << " rows a second, " << step_m;
      }
    }
  }
}

TEST_F(RecordedHand, WhatRepeatsAreTakenForIsTold) {
  EXPECT_THAT(open(logged(0, 60, 1000, 0))->warnings(),
              testing::ElementsAre(AllOf(HasSubstr("of 5000 rows repeat"), HasSubstr("a logger"), HasSubstr("left out"))));
  std::string text = "t_s,x_m,y_m,z_m\n";
  char row[100];
  for (int i = 0; i < 500; ++i) {
    std::snprintf(row, sizeof row, "%.17g,%.17g,0,0\n", i * 1e-3, std::round(0.01 * i * 1e-3 / 55e-6) * 55e-6);
    text += row;
  }
  EXPECT_THAT(open(text)->warnings(), testing::ElementsAre(AllOf(HasSubstr("encoder"), HasSubstr("kept"))));
  EXPECT_THAT(open("t_s,x_m,y_m,z_m\n0,0,0,0\n0.01,1,0,0\n0.02,1,0,0\n0.03,2,0,0\n")->warnings(), testing::IsEmpty());
}

// At any end of the text: complete lines count, the rest is left out and reported.
TEST_F(RecordedHand, ALastLineWithoutItsEndIsLeftOut) {
  for (const std::string header : {"t_s,x_m,y_m,z_m\n", "tick,t_s,probe_x_m,probe_y_m,probe_z_m,probe_valid,buttons\n"}) {
    const bool is_own = header.starts_with("tick");
    const std::string whole = header + (is_own ? "0,0,1,2,3,1,0\n1,0.01,2,2,3,1,0\n" : "0,1,2,3\n0.01,2,2,3\n");
    const std::string last = is_own ? "2,0.0213,0.125,0.25,0.375,1,0\n" : "0.0213,0.125,0.25,0.375\n";
    for (std::size_t cut = 0; cut <= last.size(); ++cut) {
      const auto hand = open(whole + last.substr(0, cut));
      EXPECT_EQ(hand->duration_s(), cut == last.size() ? 0.0213 : 0.01) << cut;
      EXPECT_EQ(hand->at(0.01).position_m, (Vec3{2, 2, 3})) << cut;
      const auto told = hand->warnings();
      ASSERT_EQ(told.size(), cut > 0 && cut < last.size() ? 1u : 0u) << cut;
      if (!told.empty()) {
        EXPECT_THAT(told[0], AllOf(HasSubstr("line 4 has no end"), HasSubstr("left out")));
      }
    }
  }
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n0,1,2,3"), HasSubstr("no row with a position that ends like a line"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n0,1,2\n0.01,1,2,3"), HasSubstr("hand.csv:2: has 3 cells")) << "a line with an end";
}

// ---- positions of a program ----

TEST_F(RecordedHand, GivenPositionsAreThoseOfTheirTicks) {
  std::vector<Vec3> path_m;
  for (int n = 0; n < 20'000; ++n) path_m.push_back({1e-3 * std::sin(0.1 * n), 1e-6 * n, 0.7});
  for (const double dt_s : {1e-3, 1.0 / 3000.0, 0.37e-3}) {
    const auto hand = hand_device(sampled_target(path_m, dt_s), Hold::rigid);
    EXPECT_TRUE(sampled_target(path_m, dt_s)->has_own_placement());
    for (const Vec3& row_m : path_m) {
      const DeviceState state = hand->read();
      ASSERT_TRUE(state.valid);
      ASSERT_EQ(state.position_m, row_m);
      hand->advance(dt_s);
    }
    EXPECT_FALSE(hand->read().valid) << "after the last";
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto holed = sampled_target(std::vector<Vec3>{{nan, 0, 0}, {1, 2, 3}, {0, nan, 0}, {4, 5, 6}}, 0.01);
  EXPECT_FALSE(holed->at(0.0).valid);
  EXPECT_TRUE(holed->at(0.01).valid);
  EXPECT_FALSE(holed->at(0.02).valid);
  for (double t = -0.01; t < 0.05; t += 0.001) EXPECT_TRUE(is_finite(holed->at(t).position_m)) << t;
  EXPECT_THROW(sampled_target({}, 0.01), LoadError);
  EXPECT_THROW(sampled_target(std::vector<Vec3>{{nan, 0, 0}}, 0.01), LoadError);
  EXPECT_THROW(sampled_target(std::vector<Vec3>{{1e4, 0, 0}}, 0.01), LoadError);
  for (const double wrong : {0.0, -1e-3, 16.0, nan}) EXPECT_THROW(sampled_target(path_m, wrong), LoadError);
}

TEST_F(RecordedHand, AHandThatRestsIsNoGap) {
  std::string text = "t_s,x_m,y_m,z_m\n0,0,0,0\n";
  for (int i = 1; i < 100; ++i) text += std::to_string(i * 0.01) + ",0.5,0,0\n";
  text += "1.0,0.6,0,0\n";
  const auto hand = open(text);
  for (double t = 0; t <= 1.0; t += 0.003) EXPECT_TRUE(hand->at(t).valid) << t;
  for (double t = 0.01; t <= 0.9; t += 0.003) EXPECT_EQ(hand->at(t).position_m.x, 0.5) << t;
}

TEST_F(RecordedHand, OfRowsAtOneTimeTheLastCounts) {
  const auto hand = open("t_s,x_m,y_m,z_m\n0,1,0,0\n0,2,0,0\n0.05,3,0,0\n0.05,4,0,0\n");
  EXPECT_EQ(hand->at(0).position_m.x, 2);
  EXPECT_EQ(hand->at(0.05).position_m.x, 4);
}

TEST_F(RecordedHand, OneRowIsEnough) {
  const auto hand = open("t_s,x_m,y_m,z_m\n7,1,2,3\n");
  EXPECT_EQ(hand->duration_s(), 0);
  EXPECT_EQ(hand->at(0).position_m, (Vec3{1, 2, 3}));
  EXPECT_TRUE(hand->at(0).valid);
}

TEST_F(RecordedHand, TimesThatLieExtremelyCloseStayFinite) {
  const auto hand = open("t_s,x_m,y_m,z_m\n0,1,0,0\n1e-320,999,0,0\n2e-310,-999,0,0\n0.01,5,0,0\n");
  for (double t : {0.0, 5e-321, 1e-320, 1e-310, 1e-300, 1e-5, 0.005, 0.01}) EXPECT_TRUE(is_finite(hand->at(t).position_m)) << t;
}

// ---- errors ----

TEST_F(RecordedHand, WhatFitsNoFormIsToldTheFourForms) {
  for (const char* text : {"", "a,b,c\n1,2,3\n", "t_s,x_m,y_m\n0,1,2\n", "Fx,Fy,Fz,Tx,Ty,Tz\n1,2,3,4,5,6\n", "\x01\x02\x03"}) {
    EXPECT_THAT(error(text), AllOf(HasSubstr("hand.csv"), HasSubstr("ticks.csv"), HasSubstr("t_s,x_m,y_m,z_m[,buttons]"),
                                   HasSubstr("Cursor Position X"), HasSubstr("x,y,z,"), HasSubstr("--hand-rate-hz")))
        << text;
  }
}

TEST_F(RecordedHand, EachErrorNamesItsLine) {
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n"), HasSubstr("no row with a position"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n0,nan,0,0\n"), HasSubstr("no row with a position"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n0,1,2,3\n0.1,1,2\n"), HasSubstr("hand.csv:3: has 3 cells; the header has 4"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n0,1,2,3\n\n0.1,1,two,3\n"), HasSubstr("hand.csv:4: 'two' is no number"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n0,1,,3\n"), HasSubstr("hand.csv:2: '' is no number"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n1,1,2,3\n0.5,1,2,3\n"), HasSubstr("hand.csv:3: the time falls"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\nnan,1,2,3\n"), HasSubstr("hand.csv:2: the time is not finite"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n0,1e4,2,3\n"),
              HasSubstr("hand.csv:2: the position is more than 1000 m away; positions are metres"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n0,-1e4,2,3\n"), HasSubstr("1000 m"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n" + std::string(100'000, '1')), HasSubstr("hand.csv:2: the line is longer"));
  EXPECT_THAT(error("x,y,z\n1,2,3\n"), HasSubstr("has no times; give the rows per second with --hand-rate-hz"));
  EXPECT_THAT(error("x,y,z\n1,2,3\n", {.hand_rate_hz = -1}), HasSubstr("--hand-rate-hz"));
  EXPECT_THAT(error("t_s,x_m,y_m,z_m\n0,1,2,3\n", {.hand_rate_hz = 100}), HasSubstr("leave out --hand-rate-hz"));
  const auto open_path = [](const fs::path& path) {
    try {
      recorded_target(path);
    } catch (const LoadError& refused) {
      return std::string(refused.what());
    }
    return std::string("(no error)");
  };
  EXPECT_THAT(open_path(root() / "none.csv"), HasSubstr("does not exist"));
  EXPECT_THAT(open_path(root()), HasSubstr("is a folder"));
}

// ---- real recordings ----

TEST_F(RecordedHand, RealRecordingsAreReadAsTheirDescriptionSays) {
  const fs::path folder = test::shared_data("trajectories");
  if (!fs::exists(folder)) GTEST_SKIP() << "no real recordings: set PALPA_SHARED to the folder of shared data";
  struct Described {
    const char* file;
    double duration_s;
    Vec3 extent_mm;
  };
  for (const Described& known : {Described{"inverse3_woodcarving_20231121_102837.csv", 26.3, {79, 150, 47}},
                                 Described{"inverse3_woodcarving_20231122_134055.csv", 8.6, {165, 166, 115}},
                                 Described{"inverse3_woodcarving_20231122_135304.csv", 41.1, {116, 130, 121}}}) {
    const auto hand = recorded_target(folder / known.file);
    EXPECT_NEAR(hand->duration_s(), known.duration_s, 0.06) << known.file;
    Vec3 low, high;
    int valid = 0, total = 0;
    for (double t = 0; t < hand->duration_s(); t += 1e-3, ++total) {
      const Target::Point point = hand->at(t);
      valid += point.valid;
      low = {std::min(low.x, point.position_m.x), std::min(low.y, point.position_m.y), std::min(low.z, point.position_m.z)};
      high = {std::max(high.x, point.position_m.x), std::max(high.y, point.position_m.y), std::max(high.z, point.position_m.z)};
    }
    EXPECT_EQ(valid, total) << known.file << ": no gap of these is longer than 40 ms";
    // Centred in each direction, with the documented extent.
    EXPECT_NEAR(largest_component(low + high), 0, 2e-4);
    EXPECT_NEAR(largest_component(1e3 * (high - low) - known.extent_mm), 0, 0.7) << known.file;
  }
  const auto baton = recorded_target(folder / "handover_a_baton_pose.csv", {.hand_rate_hz = 120});
  EXPECT_NEAR(baton->duration_s(), 800 / 120.0, 1e-12);
  EXPECT_THROW(recorded_target(folder / "handover_a_wrench_interaction.csv", {.hand_rate_hz = 120}), LoadError);
}

}  // namespace recorded_hand_test
}  // namespace palpa
