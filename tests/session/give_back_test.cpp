// Force of a hand at rest after any history: k times the extension; force withheld by unfinished ticks returns in 20 ms,
// without a step, and is booked.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "palpa/session/session.h"
#include "tests/session/hands.h"
#include "tests/session/resting_hands.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace give_back_test {

constexpr double k = test::resting_n_per_m;
constexpr double give_back_s = 0.02;
constexpr double slew_n_per_s = 1000.0;
constexpr double spacing_m = 1e-3;

/// Runs a scene, and checks every tick.
class Felt {
 public:
  Felt(const Scene& scene, double rate_hz) : session_(scene), time_step_s_(1.0 / rate_hz) {}

  Tick tick(const Vec3& at_m) {
    const Tick t = session_.tick({.position_m = at_m}, time_step_s_);
    if (has_begun_) judge(t);
    has_begun_ = true;
    last_ = t;
    return t;
  }
  /// Until no motion is pending and all force is returned, 10 s at most.
  Tick settle(const Vec3& at_m) {
    Tick t = tick(at_m);
    for (double s = 0.0; s < 10.0 && (t.status == TickStatus::waiting || rests_s_ < 0.06); s += time_step_s_) t = tick(at_m);
    EXPECT_NE(t.status, TickStatus::waiting) << "a hand at rest is followed to the end";
    return t;
  }
  int waiting() const { return waiting_; }
  /// Ticks at rest with 0.1 N or more still to return.
  int withheld() const { return withheld_; }
  Session& session() { return session_; }

 private:
  static Vec3 due_n(const Tick& t) { return k * (t.proxy_m - t.probe_m); }

  void judge(const Tick& t) {
    const bool waits = t.status == TickStatus::waiting;
    waiting_ += waits;
    rests_s_ = waits ? 0.0 : rests_s_ + time_step_s_;
    const double missing_n = distance(t.force_n, due_n(t));
    withheld_ += !waits && missing_n > 0.1;
    most_missing_n_ = waits ? 0.0 : std::max(most_missing_n_, missing_n);
    if (rests_s_ >= std::max(give_back_s * (1.0 - 1e-9), most_missing_n_ / slew_n_per_s + 0.015)) {
      EXPECT_LE(missing_n, 1e-12 * norm(due_n(t)));
    }
    const double withheld_before_n = distance(last_.force_n, due_n(last_));
    const bool holds_back = waits || withheld_before_n > 1e-12;
    if (holds_back && t.probe_step_m == Vec3{}) {
      EXPECT_LE(test::grown_n(t.force_n, last_.force_n), slew_n_per_s * time_step_s_ + 1e-12) << "a step";
    }
    judge_energy(t, waits, holds_back);
  }

  void judge_energy(const Tick& t, bool waits, bool holds_back) {
    const Energy& e = t.energy;
    const double given_j = dot(last_.force_n, t.probe_step_m);
    const double lost_j = last_.energy.stored_j - e.stored_j + e.sampling_bound_j + e.injected_j - e.dissipated_j +
                          e.data_motion_j + e.path_and_release_j + e.damper_j;
    const double all_j = last_.energy.stored_j + e.stored_j + e.sampling_bound_j + std::abs(e.path_and_release_j);
    EXPECT_NEAR(given_j, lost_j, 1e-12 * all_j + 1e-15) << "the books close";
    const double felt_j = 0.5 / k * norm_squared(t.force_n), rounded_j = 1e-12 * all_j + 1e-15;
    if (!waits) {
      EXPECT_LE(felt_j, e.stored_j + rounded_j) << "no more is felt than the spring holds";
    }
    if (holds_back && waits) {
      EXPECT_LE(given_j, 0.5 / k * norm_squared(last_.force_n) - felt_j + e.sampling_bound_j + rounded_j);
    }
  }

  Session session_;
  double time_step_s_;
  bool has_begun_ = false;
  double rests_s_ = 1.0;
  double most_missing_n_ = 0.0;
  Tick last_;
  int waiting_ = 0, withheld_ = 0;
};

void come(Felt& felt, const test::RestingHand& hand) {
  for (int i = 0; i <= 40; ++i) felt.tick(hand.from_m + i / 40.0 * (hand.at_m - hand.from_m));
  felt.settle(hand.at_m);
}

void expect_held(const test::RestingHand& hand, const Tick& t) {
  if (hand.held_n == Vec3{}) return;
  EXPECT_LE(distance(t.force_n, hand.held_n), 1e-3) << "the wall is where it was";
}

// One or some samples at another position, then back.
void glitch(Felt& felt, const test::RestingHand& hand, const Vec3& away_m, int samples) {
  for (int i = 0; i < samples; ++i) felt.tick(hand.at_m + away_m);
  expect_held(hand, felt.settle(hand.at_m));
}

TEST(GivenBack, AfterAGlitchTheHandHasItsForce) {
  const auto directions = test::all_directions();
  std::size_t turn = 0;
  int waiting = 0, withheld = 0;
  for (const test::RestingHand& hand : test::resting_hands(spacing_m)) {
    for (const double rate_hz : test::resting_rates_hz) {
      Felt felt(hand.scene, rate_hz);
      come(felt, hand);
      for (const double far_m : {0.001, 0.005, 0.02, 0.1, 1.0}) {
        // Few of the longest: they take a hundred ticks each.
        for (std::size_t i = 0; i < (far_m < 0.05 ? directions.size() : far_m < 0.5 ? 6 : 1); ++i) {
          SCOPED_TRACE(hand.name + ", " + std::to_string(rate_hz) + " Hz, glitch of " + std::to_string(far_m) + " m");
          turn += 7;  // no multiple of 26: all come
          glitch(felt, hand, far_m * directions[turn % directions.size()], 1 + static_cast<int>(turn) % 3);
          if (HasFailure()) return;
        }
      }
      waiting += felt.waiting();
      withheld += felt.withheld();
    }
  }
  EXPECT_GT(waiting, 1000);
  EXPECT_GT(withheld, 1000) << "nothing was withheld";
}

// The whole force is back 50 ms after the hand, for any bad sample: of the path to it and back only the part
// walked by a tick is walked. At low rates a glitch below 10 m/s may be a stroke, and is walked.
TEST(GivenBack, WithinFiftyMillisecondsOfAGlitch) {
  const auto directions = test::all_directions();
  std::size_t turn = 0;
  double longest_s = 0.0;
  for (const test::RestingHand& hand : test::resting_hands(spacing_m)) {
    for (const double rate_hz : test::resting_rates_hz) {
      Felt felt(hand.scene, rate_hz);
      come(felt, hand);
      for (const double far_m : {0.001, 0.01, 0.1, 0.3, 1.0}) {
        if (far_m >= 0.1 && far_m * rate_hz <= 10.0) continue;
        for (int samples = 1; samples <= 3; ++samples) {
          SCOPED_TRACE(hand.name + ", " + std::to_string(rate_hz) + " Hz, glitch of " + std::to_string(far_m) + " m");
          turn += 7;
          for (int i = 0; i < samples; ++i) felt.tick(hand.at_m + far_m * directions[turn % directions.size()]);
          double passed_s = 0.0;
          for (int i = 0; i < 20000; ++i, passed_s += 1.0 / rate_hz) {
            const Tick t = felt.tick(hand.at_m);
            if (t.status != TickStatus::waiting && distance(t.force_n, k * (t.proxy_m - t.probe_m)) <= 1e-9) break;
          }
          EXPECT_LE(passed_s, 0.05 + 1.0 / rate_hz);
          longest_s = std::max(longest_s, passed_s);
          if (HasFailure()) return;
          felt.settle(hand.at_m);
        }
      }
    }
  }
  EXPECT_GT(longest_s, 0.01) << "nothing was withheld";
}

TEST(GivenBack, AfterAGlitchInAnyDirectionTheWallIsThere) {
  const test::RestingHand hand = test::resting_hands(spacing_m).front();
  for (const double rate_hz : test::resting_rates_hz) {
    for (const Vec3& direction : test::all_directions()) {
      Felt felt(hand.scene, rate_hz);
      come(felt, hand);
      glitch(felt, hand, 0.04 * direction, 1);
    }
  }
}

TEST(GivenBack, AfterAFastStrokeTheHandHasItsForce) {
  int withheld = 0;
  for (const test::RestingHand& hand : test::resting_hands(0.5 * spacing_m)) {
    for (const double rate_hz : {100.0, 150.0, 250.0, 500.0, 1000.0, 10000.0}) {
      for (const double speed_m_per_s : {0.5, 1.5, 2.0, 5.0, 20.0}) {
        for (const Vec3& away : {Vec3{1, 0, 0}, Vec3{0, 0, 1}, Vec3{0.6, 0.0, 0.8}, Vec3{0.36, 0.48, 0.8}}) {
          SCOPED_TRACE(hand.name + ", " + std::to_string(rate_hz) + " Hz, " + std::to_string(speed_m_per_s) + " m/s");
          Felt felt(hand.scene, rate_hz);
          const double offset_m = 0.06, step_m = speed_m_per_s / rate_hz;
          come(felt, hand);
          for (double far_m = 0.0; far_m < offset_m; far_m += step_m) felt.tick(hand.at_m + far_m * away);
          for (double left_m = offset_m; left_m > 0.0; left_m -= step_m) felt.tick(hand.at_m + left_m * away);
          expect_held(hand, felt.settle(hand.at_m));
          withheld += felt.withheld();
          if (HasFailure()) return;
        }
      }
    }
  }
  EXPECT_GT(withheld, 200) << "nothing was withheld";
}

// The hand moves on during the return: all force is there in time, and the spring holds it.
TEST(GivenBack, ToAHandThatMovesOn) {
  test::Random random(3);
  int withheld = 0;
  for (const test::RestingHand& hand : test::resting_hands(spacing_m)) {
    for (const double rate_hz : test::resting_rates_hz) {
      SCOPED_TRACE(hand.name + ", " + std::to_string(rate_hz) + " Hz");
      Felt felt(hand.scene, rate_hz);
      come(felt, hand);
      const test::Wander wander(random, 0.002);
      for (int i = 0; i < 600; ++i) {
        const bool jumps = random.uniform(0, 1) < 0.02;
        felt.tick(hand.at_m + wander.at(i / rate_hz) - wander.at(0.0) + (jumps ? random.in_cube(0.05) : Vec3{}));
      }
      felt.settle(hand.at_m);
      withheld += felt.withheld();
    }
  }
  EXPECT_GT(withheld, 300);
}

// The returned force is the spring's, not paid by the hand: two columns of the ledger have booked it by then, with all earlier
// returns, less the modes' work.
TEST(GivenBack, IsBookedBeforeItIsFelt) {
  test::Random random(4);
  int returns = 0;
  double returned_j = 0.0;
  for (const test::RestingHand& hand : test::resting_hands(spacing_m)) {
    Session session(hand.scene);
    double account_j = 0.0, given_j = 0.0;
    Vec3 at_m = hand.from_m;
    Tick last = session.tick({.position_m = at_m}, 1e-3);
    for (int i = 0; i < 6000; ++i) {
      // In by fast strokes, out slowly, repeated: withheld energy would be won by this.
      const int phase = i % 120;
      at_m = phase < 60    ? hand.at_m
             : phase < 118 ? hand.at_m + (phase - 59) / 58.0 * (hand.from_m - hand.at_m)
                           : hand.from_m + random.in_cube(0.05);
      const Tick t = session.tick({.position_m = at_m}, 1e-3);
      given_j += dot(last.force_n, t.probe_step_m);
      account_j += t.energy.sampling_j + t.energy.damper_j + t.energy.injected_j - t.energy.dissipated_j;
      const double felt_before_j = 0.5 / k * norm_squared(last.force_n), felt_j = 0.5 / k * norm_squared(t.force_n);
      if (t.status != TickStatus::waiting && t.probe_step_m == Vec3{} && felt_j > felt_before_j + 1e-9) {
        ++returns;
        returned_j += felt_j - felt_before_j;
        ASSERT_GE(account_j, given_j + felt_j - 1e-9) << hand.name << ", tick " << i;
      }
      last = t;
    }
  }
  EXPECT_GT(returns, 500);
  EXPECT_GT(returned_j, 0.01);
}

// The damper acts on hands only, not on the returning force.
TEST(GivenBack, IsNothingToDamp) {
  const auto damped = test::resting_hands(spacing_m, 5.0);
  for (const double rate_hz : test::resting_rates_hz) {
    Session session(damped.front().scene);
    const Vec3 at_m = damped.front().at_m;
    const double dt_s = 1.0 / rate_hz;
    for (int i = 0; i <= 40; ++i)
      session.tick({.position_m = damped.front().from_m + i / 40.0 * (at_m - damped.front().from_m)}, dt_s);
    Tick t;
    for (double s = 0.0; s < 0.1; s += dt_s) t = session.tick({.position_m = at_m}, dt_s);
    session.tick({.position_m = at_m + Vec3{0.05, 0, 0}}, dt_s);
    for (double s = 0.0, rests_s = 0.0; rests_s < 0.06 && s < 1.0; s += dt_s) {
      t = session.tick({.position_m = at_m}, dt_s);
      rests_s = t.status == TickStatus::waiting ? 0.0 : rests_s + dt_s;
      // Once the jump is damped the force is at most the wall's; damping the return would add to it.
      if (rests_s > 0.012) {
        EXPECT_LE(norm(t.force_n), 1.2 + 1e-3) << rate_hz << " Hz, " << rests_s;
      }
    }
    EXPECT_NEAR(t.force_n.z, 1.2, 1e-3) << rate_hz;
  }
}

// Withheld force is kept across a state copy and a changed scene; a reset discards it.
TEST(GivenBack, WhereAnotherSessionGoesOn) {
  const auto hands = test::resting_hands(spacing_m);
  const test::RestingHand& hand = hands.front();
  Felt felt(hand.scene, 1000.0);
  come(felt, hand);
  felt.tick(hand.at_m + Vec3{0.05, 0, -0.02});
  Tick t;
  do t = felt.tick(hand.at_m);
  while (t.status == TickStatus::waiting);
  ASSERT_GT(std::abs(t.force_n.z - hand.held_n.z), 0.1);

  Session copy(hand.scene), stiffer(hand.scene), reset(hand.scene);
  Scene changed = hand.scene;
  changed.edit<CouplingOptions>([&](auto& coupling) { coupling.stiffness_n_per_m = 2.0 * k; });
  Session other(changed);
  copy.copy_state_from(felt.session());
  other.resume_in_changed_scene(felt.session());
  reset.copy_state_from(felt.session());
  reset.reset();
  Tick of_copy, of_other, of_reset;
  for (int i = 0; i < 30; ++i) {
    t = felt.tick(hand.at_m);
    of_copy = copy.tick({.position_m = hand.at_m}, 1e-3);
    of_other = other.tick({.position_m = hand.at_m}, 1e-3);
    of_reset = reset.tick({.position_m = hand.at_m}, 1e-3);
    EXPECT_EQ(of_copy.force_n, t.force_n);
    EXPECT_LE(of_other.force_n.z, 2.0 * hand.held_n.z + 1e-3);
    EXPECT_EQ(of_reset.force_n, k * (of_reset.proxy_m - of_reset.probe_m));
  }
  EXPECT_NEAR(of_other.force_n.z, 2.0 * hand.held_n.z, 1e-3);
  EXPECT_NEAR(of_copy.force_n.z, hand.held_n.z, 1e-3);
}

}  // namespace give_back_test
}  // namespace palpa
