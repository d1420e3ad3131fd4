// Impact: pulse of a contact on hard material, which grows with its speed.
#include "palpa/guard/impact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/guard/break_through_filter.h"
#include "palpa/guard/guard.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace impact_test {

using test::Random;

constexpr double stiffness_n_per_m = 500.0, decay_s = 0.004, whole_s = 0.020;
constexpr double rigid = std::numeric_limits<double>::infinity();

/// Solid behind the plane through the origin across `normal`.
struct Wall {
  double gain_ns_per_m = 0.0;
  double strength_n = 8.0;
  double level_n_per_m = rigid;
  double max_force_n = 10.0;
  Mat3 rotation = Mat3::identity();  ///< its normal is that of z
  Vec3 normal() const { return rotation * Vec3{0, 0, 1}; }
};

Scene scene_of(const Wall& wall) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .max_force_n = wall.max_force_n, .impact_ns_per_m = wall.gain_ns_per_m});
  SurfaceAndFriction surface;
  surface.field = scene.add("wall", plane_field(), {.rotation = wall.rotation});
  surface.levels = {{.name = "wall", .value = 0.0, .strength_n = Strength{wall.strength_n}}};
  if (wall.level_n_per_m < rigid) surface.levels[0].stiffness_n_per_m = wall.level_n_per_m;
  scene.add("surface", surface);
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
  return scene;
}

/// Two hands on one path, with and without impacts.
class Both {
 public:
  explicit Both(const Wall& wall, double dt_s = 1e-3, double device_max_force_n = 50.0)
      : dt_s_(dt_s),
        with_(scene_of(wall)),
        without_(scene_of([&] {
          Wall silent = wall;
          silent.gain_ns_per_m = 0.0;
          return silent;
        }())),
        guarded_with_(with_, device_max_force_n),
        guarded_without_(without_, device_max_force_n) {}

  void go(const Vec3& to_m) {
    const Probe probe{.position_m = to_m};
    felt = guarded_with_.tick(n_, dt_s_ * static_cast<double>(n_), dt_s_, probe);
    plain = guarded_without_.tick(n_, dt_s_ * static_cast<double>(n_), dt_s_, probe);
    ++n_;
    met = std::ranges::any_of(with_.events(), [](const SessionEvent& event) { return event.kind == SessionEventKind::onset; });
  }
  Vec3 pulse_n() const { return felt.command.force_n - plain.command.force_n; }

  TickFrame felt, plain;
  bool met = false;

 private:
  double dt_s_;
  std::int64_t n_ = 0;
  Session with_, without_;
  GuardedSession guarded_with_, guarded_without_;
};

/// The pulses of a straight hand, from 10 mm before the wall, for 0.2 s; the first is at the onset's tick.
std::vector<Vec3> pulses_of(const Wall& wall, const Vec3& velocity_m_per_s, double dt_s = 1e-3) {
  Both both(wall, dt_s);
  std::vector<Vec3> pulses_n;
  for (int i = 0; dt_s * i < 0.2; ++i) {
    both.go(0.01 * wall.normal() + dt_s * i * velocity_m_per_s);
    if (!both.met && pulses_n.empty()) {
      EXPECT_EQ(both.felt.command.force_n, both.plain.command.force_n) << "before anything is hit";
    } else {
      pulses_n.push_back(both.pulse_n());
    }
  }
  return pulses_n;
}

double share_at(double t_s) {
  const double end = std::exp(-whole_s / decay_s);
  return t_s < whole_s ? (std::exp(-t_s / decay_s) - end) / (1.0 - end) : 0.0;
}

// From any side, at any rate: gain times the normal speed at first, then its curve, then 0.
TEST(Impact, IsGainTimesTheSpeedAlongTheNormalAndDecaysToNothing) {
  Random random(1);
  for (int run = 0; run < 100; ++run) {
    const double dt_s = run % 3 == 0 ? 1e-3 : random.uniform(2e-4, 2e-3);
    Wall wall{.gain_ns_per_m = random.uniform(1.0, 20.0), .rotation = random.rotation()};
    const double speed_m_per_s = random.uniform(0.06, 0.2);
    const Vec3 aside = random.uniform(0.0, 0.3) * (wall.rotation * Vec3{std::cos(run), std::sin(run), 0});
    wall.max_force_n = 100.0;
    wall.strength_n = 100.0;
    const std::vector<Vec3> pulses_n = pulses_of(wall, aside - speed_m_per_s * wall.normal(), dt_s);
    ASSERT_GT(pulses_n.size(), 5u) << run;
    for (std::size_t i = 0; i < pulses_n.size(); ++i) {
      const double t_s = dt_s * static_cast<double>(i);
      if (std::abs(t_s - whole_s) < 1e-9) continue;
      const Vec3 expected_n = wall.gain_ns_per_m * speed_m_per_s * share_at(t_s) * wall.normal();
      ASSERT_NEAR(distance(pulses_n[i], expected_n), 0.0, 1e-6) << run << ", " << i;
    }
    EXPECT_EQ(pulses_n.back(), Vec3{});
  }
}

TEST(Impact, IsNothingWithoutAGain) {
  Session session(scene_of({})), same(scene_of({}));
  GuardedSession guarded(session, 3.3);
  Guard guard(3.3);
  BreakThroughFilter release;
  same.set_force_limit(3.3);
  for (int i = 0; i < 400; ++i) {
    const Probe probe{.position_m = {1e-4 * i, 0.0, 0.01 - 2e-4 * i}};
    const TickFrame frame = guarded.tick(i, 1e-3 * i, 1e-3, probe);
    const Vec3 passed_n = guard.pass(same.tick(probe, 1e-3).force_n).command_n;
    const Vec3 shaped_n = release.shape({passed_n, {}}, false, 0.1, 1e-3, false, 1.0).force_n;
    ASSERT_EQ(frame.command.force_n, guard.pass(shaped_n).command_n) << i;
  }
}

// Levels stiffer than the coupling are hard; softer ones are not, and weak ones cannot knock hard.
TEST(Impact, IsOfHardLevelsAndNeverHigherThanTheyAreStrong) {
  const Vec3 down{0, 0, -0.1};
  for (const double softer : {0.1, 0.9, 1.0}) {
    for (const Vec3& pulse_n : pulses_of({.gain_ns_per_m = 10.0, .level_n_per_m = softer * stiffness_n_per_m}, down))
      EXPECT_EQ(pulse_n, Vec3{}) << softer;
  }
  for (const double harder : {1.1, 10.0, rigid})
    EXPECT_NEAR(pulses_of({.gain_ns_per_m = 10.0, .level_n_per_m = harder * stiffness_n_per_m}, down)[0].z, 1.0, 1e-6);
  for (const double strength_n : {0.2, 0.7})
    EXPECT_NEAR(pulses_of({.gain_ns_per_m = 10.0, .strength_n = strength_n}, down)[0].z, strength_n, 1e-6) << strength_n;
}

TEST(Impact, StaysWithinTheGuard) {
  Random random(2);
  for (int run = 0; run < 100; ++run) {
    const double scene_n = random.uniform(0.5, 6.0), device_n = random.uniform(0.5, 6.0);
    const Wall wall{.gain_ns_per_m = 100.0, .max_force_n = scene_n, .rotation = random.rotation()};
    Both both(wall, 1e-3, device_n);
    double most_n = 0.0;
    const Vec3 velocity_m_per_s = 0.2 * random.direction() - random.uniform(0.3, 2.0) * wall.normal();
    for (int i = 0; i < 300; ++i) {
      both.go(0.02 * wall.normal() + 1e-3 * i * velocity_m_per_s);
      ASSERT_LE(norm(both.felt.command.force_n), std::min(scene_n, device_n));
      most_n = std::max(most_n, norm(both.felt.command.force_n));
    }
    EXPECT_GT(most_n, 0.99 * std::min(scene_n, device_n));
  }
}

// The ledger: the pulse's work on the hand equals the difference between force and command.
TEST(Impact, IsBookedAsTheWorkThatItDoes) {
  Random random(3);
  for (int run = 0; run < 50; ++run) {
    const Wall wall{.gain_ns_per_m = random.uniform(1.0, 30.0)};
    Both both(wall);
    Vec3 pulse_before_n, force_before_n;
    double worked_j = 0.0, booked_j = 0.0;
    const double speed_m_per_s = random.uniform(0.05, 0.4), turns_m = random.uniform(0.001, 0.008);
    for (int i = 0; i < 400; ++i) {
      const double z_m = 0.01 - speed_m_per_s * 1e-3 * i;
      both.go({1e-5 * i, 0.0, std::max(z_m, -turns_m) + 0.3 * std::max(0.0, -turns_m - z_m)});
      const Vec3& step_m = both.felt.result.probe_step_m;
      const Command& command = both.felt.command;
      worked_j += dot(pulse_before_n, step_m);
      booked_j -= command.withheld_j - both.plain.command.withheld_j;
      ASSERT_NEAR(dot(force_before_n, step_m), command.work_on_hand_j + command.withheld_j, 1e-15);
      pulse_before_n = both.pulse_n();
      force_before_n = both.felt.result.force_n;
    }
    EXPECT_NEAR(booked_j, worked_j, 1e-12) << run;
    EXPECT_GT(std::abs(worked_j), 1e-6) << run;
  }
}

// A free hand of mass m takes the impulse g v Σ share dt: it leaves no faster than it came up to 2m, and faster beyond.
TEST(Impact, GivesAFreeHandNoEnergyUpToTwiceItsMassOverThePulse) {
  const double dt_s = 1e-3;
  double sum_s = 0.0;
  for (int i = 0; i < 20; ++i) sum_s += dt_s * share_at(dt_s * i);
  for (const double mass_kg : {0.05, 0.15}) {
    for (const double share : {0.5, 0.98, 1.1}) {
      Both both({.gain_ns_per_m = share * 2.0 * mass_kg / sum_s, .strength_n = 100.0, .max_force_n = 100.0}, dt_s, 100.0);
      double z_m = 0.01, v_m_per_s = -0.1;
      for (int i = 0; i < 400; ++i) {
        both.go({0, 0, z_m});
        const double a = both.pulse_n().z / mass_kg;
        z_m += dt_s * (v_m_per_s + 0.5 * a * dt_s);
        v_m_per_s += a * dt_s;
      }
      EXPECT_NEAR(v_m_per_s, -0.1 * (1.0 - 2.0 * share), 1e-6) << mass_kg << ", " << share;
    }
  }
}

// A device that loses the hand: the pulse ends, and the speed before is discarded.
TEST(Impact, IsForgottenWithTheHand) {
  const Wall wall{.gain_ns_per_m = 10.0};
  Session session(scene_of(wall));
  GuardedSession guarded(session, 50.0);
  int i = 0;
  for (; session.events().empty(); ++i) guarded.tick(i, 1e-3 * i, 1e-3, {.position_m = {0, 0, 0.01 - 1e-4 * i}});
  EXPECT_EQ(guarded.tick(i, 1e-3 * i, 1e-3, {.position_m = {0, 0, 0.02}, .valid = false}).command.force_n, Vec3{});
  for (int n = 1; n < 30; ++n)
    EXPECT_EQ(guarded.tick(i + n, 1e-3 * (i + n), 1e-3, {.position_m = {0, 0, 0.02}}).command.force_n, Vec3{});
}

}  // namespace impact_test
}  // namespace palpa
