// Device calibration on a simulated device of known parameters, with a hand that follows the instructions.
#include "palpa/study/bring_up.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <deque>

namespace palpa {
namespace bring_up_test {

using testing::Contains;
using testing::HasSubstr;

struct Made {
  double mass_kg = 0.2, damping_ns_per_m = 0.4, friction_n = 0.03, encoder_step_m = 2e-5;
  int delay_ms = 3, lag_ms = 12;
  double sign = 1.0;
  const char* fault = nullptr;
  bool has_motors = true;
};

class Bench final : public Device, public LoopClock {
 public:
  explicit Bench(const Made& made) : made_(made) {}

  std::string name() const override { return "made"; }
  DeviceLimits limits() const override { return {.max_force_n = 3.0, .has_motors = made_.has_motors}; }
  DeviceState read() noexcept override {
    const auto rounded = [&](double x) { return std::round(x / made_.encoder_step_m) * made_.encoder_step_m; };
    return {.position_m = {rounded(place_.x), rounded(place_.y), rounded(place_.z)},
            .velocity_m_per_s =
                past_.size() > static_cast<std::size_t>(made_.lag_ms) ? past_[static_cast<std::size_t>(made_.lag_ms)] : Vec3{},
            .valid = made_.fault == nullptr,
            .fault = made_.fault};
  }
  bool write(const Vec3& force_n) noexcept override {
    written_n = std::max(written_n, norm(force_n));
    last_n = force_n;
    forces_.push_back(made_.sign * force_n);
    if (forces_.size() > static_cast<std::size_t>(made_.delay_ms) + 1) forces_.pop_front();
    return true;
  }

  double now_s() noexcept override { return now_s_; }
  void wait_until_s(double time_s) noexcept override {
    while (now_s_ + 1e-9 < time_s) pass(1e-4);
    past_.push_front(speed_);
    if (past_.size() > 100) past_.pop_back();
  }

  /// The hand's reaction to an instruction: strokes, loose hold, pull aside and release.
  bool obey(const std::string& words) {
    asked_s_ = now_s_;
    if (words.find("slowly") != std::string::npos) doing_ = Doing::strokes;
    if (words.find("loosely") != std::string::npos) doing_ = Doing::rests;
    if (words.find("middle of its reach.") != std::string::npos && words.find("loosely") == std::string::npos)
      doing_ = Doing::holds;
    if (words.find("let go") != std::string::npos) {
      place_ = {0.03, 0, 0};
      speed_ = {};
      doing_ = Doing::lets_go;
    } else {
      place_ = speed_ = {};
    }
    return true;
  }

  double written_n = 0.0;
  Vec3 last_n;

 private:
  enum class Doing : std::uint8_t { rests, strokes, holds, lets_go };

  void pass(double dt_s) {
    now_s_ += dt_s;
    if (doing_ == Doing::strokes) {
      const double t = now_s_ - asked_s_;
      speed_ = {0.06 * std::cos(2 * t), 0.05 * std::cos(3 * t), 0.04 * std::cos(5 * t)};
      place_ += dt_s * speed_;
      return;
    }
    // A hand that holds the handle aside releases it a second after the instruction.
    const bool is_held = doing_ == Doing::holds || (doing_ == Doing::lets_go && now_s_ - asked_s_ < 1.0);
    if (is_held) return;
    Vec3 force = forces_.empty() ? Vec3{} : forces_.front();
    const double speed = norm(speed_), friction = made_.friction_n * dt_s / made_.mass_kg;
    speed_ += (dt_s / made_.mass_kg) * (force - made_.damping_ns_per_m * speed_);
    if (speed > 0.0) speed_ -= std::min(1.0, friction / speed) * speed_;
    if (speed == 0.0 && norm(force) < made_.friction_n) speed_ = {};
    place_ += dt_s * speed_;
  }

  Made made_;
  Doing doing_ = Doing::rests;
  double now_s_ = 0.0, asked_s_ = 0.0;
  Vec3 place_, speed_;
  std::deque<Vec3> forces_, past_;
};

DeviceCalibration measured(Bench& bench) {
  const std::atomic<bool> never{false};
  return bring_up(
      bench, bench, [&](const std::string& words) { return bench.obey(words); }, never);
}

TEST(DeviceCalibration, FindsWhatTheDeviceIs) {
  for (const Made& made :
       {Made{},
        Made{.mass_kg = 0.08, .damping_ns_per_m = 0.1, .friction_n = 0.05, .encoder_step_m = 5e-5, .delay_ms = 0, .lag_ms = 0},
        Made{
            .mass_kg = 0.5, .damping_ns_per_m = 1.0, .friction_n = 0.0, .encoder_step_m = 1e-5, .delay_ms = 8, .lag_ms = 20}}) {
    Bench bench(made);
    const DeviceCalibration found = measured(bench);
    EXPECT_TRUE(found.has_valid_position);
    EXPECT_TRUE(found.pushes_rightly) << testing::PrintToString(found.findings);
    EXPECT_NEAR(found.encoder_step_m.value_or(0), made.encoder_step_m, 1e-3 * made.encoder_step_m);
    EXPECT_NEAR(found.velocity_lag_s.value_or(1), 1e-3 * made.lag_ms, 1.01e-3);
    EXPECT_NEAR(found.delay_s.value_or(1), 1e-3 * made.delay_ms, 3e-3);
    EXPECT_NEAR(found.mass_kg.value_or(0), made.mass_kg, 0.1 * made.mass_kg);
    EXPECT_NEAR(found.damping_ns_per_m.value_or(-1), made.damping_ns_per_m, 0.1 * made.damping_ns_per_m + 0.05);
    EXPECT_NEAR(found.friction_n.value_or(-1), made.friction_n, 0.1 * made.friction_n + 0.01);
  }
}

TEST(DeviceCalibration, PushesLightlyAndLeavesNoForce) {
  Bench bench(Made{});
  measured(bench);
  EXPECT_LE(bench.written_n, 1.0 + 1e-12);
  EXPECT_EQ(bench.last_n, Vec3{});
}

TEST(DeviceCalibration, SeesADeviceThatPushesTheWrongWay) {
  Bench bench(Made{.sign = -1.0});
  const DeviceCalibration found = measured(bench);
  EXPECT_FALSE(found.pushes_rightly);
  EXPECT_THAT(found.findings, Contains(HasSubstr("another way")));
}

TEST(DeviceCalibration, PushesNobodyByADeviceWithoutMotors) {
  Bench bench({.has_motors = false});
  const DeviceCalibration found = measured(bench);
  EXPECT_TRUE(found.has_valid_position);
  EXPECT_EQ(bench.written_n, 0.0);
}

TEST(DeviceCalibration, MeasuresNothingOfADeviceWithAFault) {
  Bench bench(Made{.fault = "the power supply is off: no force"});
  const DeviceCalibration found = measured(bench);
  EXPECT_FALSE(found.has_valid_position);
  EXPECT_EQ(bench.written_n, 0.0);
  EXPECT_THAT(found.findings, Contains(HasSubstr("power supply")));
}

TEST(DeviceCalibration, LeavesOutWhatAPersonDoesNotWant) {
  Bench bench(Made{});
  const std::atomic<bool> never{false};
  const DeviceCalibration found = bring_up(
      bench, bench, [](const std::string&) { return false; }, never);
  EXPECT_EQ(bench.written_n, 0.0);
  EXPECT_FALSE(found.encoder_step_m || found.delay_s || found.mass_kg);
}

}  // namespace bring_up_test
}  // namespace palpa
