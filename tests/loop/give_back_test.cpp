// The command to a hand at rest, behind the limiter: k times the extension within the limit, within 50 ms, without a step above
// the slew limit.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "palpa/loop/loop.h"
#include "tests/session/resting_hands.h"

namespace palpa {
namespace give_back_by_the_loop_test {

constexpr double k = test::resting_n_per_m;
constexpr double back_s = 0.05;
constexpr double spacing_m = 1e-3;

Vec3 due_n(const TickFrame& frame, double most_n) {
  const Vec3 n = k * (frame.result.proxy_m - frame.result.probe_m);
  return norm(n) > most_n ? most_n * normalized(n) : n;
}

/// Runs a scene behind a limiter, and checks every frame.
class Guarded {
 public:
  Guarded(const Scene& scene, double rate_hz, bool motors)
      : session_(scene),
        options_{.max_force_n = scene.coupling().max_force_n, .motors = motors},
        guarded_(session_, options_),
        time_step_s_(1.0 / rate_hz) {}

  TickFrame tick(const Vec3& at_m) {
    const TickFrame frame =
        guarded_.tick(ticks_, static_cast<double>(ticks_) * time_step_s_, time_step_s_, {.position_m = at_m});
    const bool waits = frame.result.status == TickStatus::waiting;
    rests_s_ = waits || frame.result.probe_step_m != Vec3{} ? 0.0 : rests_s_ + time_step_s_;
    const bool withheld = distance(frame.result.force_n, k * (frame.result.proxy_m - frame.result.probe_m)) > 0.1;
    withheld_ += !waits && withheld;
    if (rests_s_ > 0.0 && (was_withheld_ || options_.motors)) {
      EXPECT_LE(test::grown_n(frame.command.force_n, last_n_), options_.slew_n_per_s * time_step_s_ * (1 + 1e-9) + 1e-12)
          << "tick " << ticks_;
    }
    // A drag lets the proxy creep: the command lags by no more than the due force's change in that time.
    due_n_.push_back(due_n(frame, options_.max_force_n));
    if (!options_.motors && rests_s_ >= back_s) {
      const Vec3& before_n = due_n_[due_n_.size() - 1 - static_cast<std::size_t>(back_s / time_step_s_)];
      EXPECT_LE(distance(frame.command.force_n, due_n_.back()), distance(due_n_.back(), before_n) + 1e-6) << "tick " << ticks_;
    }
    was_withheld_ = withheld || waits;
    last_n_ = frame.command.force_n;
    ++ticks_;
    return frame;
  }
  /// For a time [s], and until all pending force has been out for 50 ms.
  TickFrame rest(const Vec3& at_m, double time_s) {
    TickFrame frame = tick(at_m);
    for (double s = time_step_s_; s < time_s || (rests_s_ < back_s + time_step_s_ && s < 10.0); s += time_step_s_)
      frame = tick(at_m);
    return frame;
  }
  double limit_n() const { return options_.max_force_n; }
  int withheld() const { return withheld_; }

 private:
  Session session_;
  GuardOptions options_;
  GuardedSession guarded_;
  double time_step_s_;
  std::int64_t ticks_ = 0;
  double rests_s_ = 0.0;
  bool was_withheld_ = false;
  int withheld_ = 0;
  Vec3 last_n_;
  std::vector<Vec3> due_n_;
};

void come(Guarded& guarded, const test::RestingHand& hand, double rate_hz) {
  guarded.rest(hand.from_m, 0.1);
  const int steps = std::max(8, static_cast<int>(0.1 * rate_hz));
  for (int i = 0; i <= steps; ++i) guarded.tick(hand.from_m + 1.0 * i / steps * (hand.at_m - hand.from_m));
  guarded.rest(hand.at_m, 1.0);
}

TEST(GivenBackByTheLoop, AfterAGlitch) {
  const auto directions = test::all_directions();
  std::size_t turn = 0;
  int withheld = 0;
  for (const test::RestingHand& hand : test::resting_hands(spacing_m)) {
    for (const double rate_hz : test::resting_rates_hz) {
      Guarded guarded(hand.scene, rate_hz, false);
      come(guarded, hand, rate_hz);
      for (const double far_m : {0.001, 0.005, 0.02, 0.1, 1.0}) {
        for (int i = 0; i < (far_m < 0.5 ? 6 : 1); ++i) {
          SCOPED_TRACE(hand.name + ", " + std::to_string(rate_hz) + " Hz, glitch of " + std::to_string(far_m) + " m");
          turn += 7;  // no multiple of 26: all come
          guarded.tick(hand.at_m + far_m * directions[turn % directions.size()]);
          const TickFrame frame = guarded.rest(hand.at_m, 0.12);
          if (hand.held_n != Vec3{}) {
            EXPECT_LE(distance(frame.command.force_n, hand.held_n), 1e-3);
          }
          if (HasFailure()) return;
        }
      }
      withheld += guarded.withheld();
    }
  }
  EXPECT_GT(withheld, 500) << "nothing was withheld";
}

// Motors: strokes without a fault end with the wall's force, without a step above the slew limit.
TEST(GivenBackByTheLoop, AfterAFastStrokeByMotors) {
  int withheld = 0;
  for (const test::RestingHand& hand : test::resting_hands(0.5 * spacing_m)) {
    for (const auto& [rate_hz, speed_m_per_s] : {std::pair{100.0, 1.9}, {150.0, 1.5}, {250.0, 1.9}, {1000.0, 1.9}}) {
      for (const Vec3& away : {Vec3{1, 0, 0}, Vec3{0.6, 0.0, 0.8}, Vec3{0.36, 0.48, 0.8}}) {
        SCOPED_TRACE(hand.name + ", " + std::to_string(rate_hz) + " Hz, " + std::to_string(speed_m_per_s) + " m/s");
        Guarded guarded(hand.scene, rate_hz, true);
        come(guarded, hand, rate_hz);
        const double step_m = speed_m_per_s / rate_hz;
        for (double far_m = 0.0; far_m < 0.06; far_m += step_m) guarded.tick(hand.at_m + far_m * away);
        for (double far_m = 0.06; far_m > 0.0; far_m -= step_m) guarded.tick(hand.at_m + far_m * away);
        const TickFrame frame = guarded.rest(hand.at_m, 2.0);
        EXPECT_LE(distance(frame.command.force_n, due_n(frame, guarded.limit_n())), 1e-6);
        if (hand.held_n != Vec3{}) {
          EXPECT_LE(distance(frame.command.force_n, hand.held_n), 1e-3);
        }
        withheld += guarded.withheld();
        if (HasFailure()) return;
      }
    }
  }
  EXPECT_GT(withheld, 50) << "nothing was withheld";
}

// A glitch too fast for a hand is a fault to motors: restart by the ramp, due force at rest.
TEST(GivenBackByTheLoop, AfterAGlitchByMotors) {
  for (const test::RestingHand& hand : test::resting_hands(spacing_m)) {
    for (const double rate_hz : test::resting_rates_hz) {
      for (const double far_m : {0.005, 0.02, 0.1}) {
        SCOPED_TRACE(hand.name + ", " + std::to_string(rate_hz) + " Hz, glitch of " + std::to_string(far_m) + " m");
        Guarded guarded(hand.scene, rate_hz, true);
        come(guarded, hand, rate_hz);
        guarded.tick(hand.at_m + far_m * Vec3{0.6, 0.0, 0.8});
        const TickFrame frame = guarded.rest(hand.at_m, 2.0);
        EXPECT_LE(distance(frame.command.force_n, due_n(frame, guarded.limit_n())), 1e-6);
        if (HasFailure()) return;
      }
    }
  }
}

}  // namespace give_back_by_the_loop_test
}  // namespace palpa
