// The damper's estimate under an encoder: ripple, delay, zeros.
#include "palpa/solver/damper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <type_traits>

namespace palpa {
namespace damper_test {

constexpr double dt = 1e-3;
constexpr double k = 500.0;

static_assert(std::is_trivially_copyable_v<Damper>);  // part of a session's StateArena

double rounded(double value_m, double step_m) { return step_m * std::floor(value_m / step_m + 0.5); }
double window_s(double damping_ns_per_m) { return 3.0 * damping_ns_per_m / k; }

TEST(DamperUnderAnEncoder, IsExactlyZeroInFreeSpaceWhateverWasBefore) {
  Damper damper(1.0, 55e-6);
  for (int i = 0; i < 20; ++i) damper.relative_velocity({0, 0, 1e-4 * i}, {}, dt, k).way_m;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(damper.relative_velocity({}, {}, dt, k).way_m, Vec3{});
}

// A steady, rounded motion: at any speed, once the window is full, the estimate is off by at most a step per window, so the
// damper's force by at most a third of the spring's own step.
TEST(DamperUnderAnEncoder, RipplesByNoMoreThanItsShareOfTheSpringsStep) {
  for (const double q : {10e-6, 23e-6, 55e-6}) {
    for (const double damping : {0.5, 1.0, 2.0}) {
      for (const double speed_m_per_s : {1e-4, 1e-3, 0.0137, 0.1, 0.3}) {
        Damper damper(damping, q);
        damper.reset({0, 0, 1.0});
        double worst = 0.0;
        for (int i = 1; i <= 1000; ++i) {
          const double stretch_m = 1.0 + rounded(speed_m_per_s * i * dt, q);
          const Vec3 seen = damper.relative_velocity({0, 0, stretch_m}, {}, dt, k).way_m;
          if (i * dt > window_s(damping) + 1.5 * dt) worst = std::max(worst, std::abs(seen.z - speed_m_per_s));
        }
        EXPECT_LE(damping * worst, k * q / 3.0 * (1 + 1e-6)) << q << " " << damping << " " << speed_m_per_s;
      }
    }
  }
}

// An encoder at rest flickers between two steps: the damper responds at most once per window.
TEST(DamperUnderAnEncoder, IsQuietWhereThePositionFlickersBetweenTwoSteps) {
  std::mt19937 engine(3);
  const double q = 55e-6, damping = 1.0;
  Damper damper(damping, q);
  damper.reset({0, 0, 0.002});
  for (int i = 0; i < 5000; ++i) {
    const Vec3 seen = damper.relative_velocity({0, 0, 0.002 + (engine() % 2 ? q : 0.0)}, {}, dt, k).way_m;
    EXPECT_LE(damping * norm(seen), k * q / 3.0 * (1 + 1e-6)) << i;
  }
}

// A jump in speed by dv appears in the estimate, up to a step over the time since, within a window.
TEST(DamperUnderAnEncoder, IsLateByNoMoreThanTheWindowAndLessTheFasterTheChange) {
  const double q = 55e-6, damping = 1.0;
  for (const double speed_m_per_s : {0.01, 0.1, 0.5}) {
    Damper damper(damping, q);
    damper.reset({0, 0, 0.5});
    // The line from before the jump leaves the tolerance of 1.4 steps at the corner as soon as the path since is longer than
    // that, beyond the corner's own share of the line.
    const double seen_after_s =
        std::min(window_s(damping), std::sqrt(1.4 * q * window_s(damping) / speed_m_per_s) + 2.4 * q / speed_m_per_s);
    for (int i = 1; i <= 30; ++i) {
      const double since_s = i * dt;
      const Vec3 seen = damper.relative_velocity({0, 0, 0.5 + rounded(speed_m_per_s * since_s, q)}, {}, dt, k).way_m;
      if (since_s >= seen_after_s + dt) {
        EXPECT_NEAR(seen.z, speed_m_per_s, 2.4 * q / std::min(since_s, window_s(damping))) << speed_m_per_s << " " << i;
      }
    }
  }
}

// A sine far above the encoder's step is damped nearly as without an encoder.
TEST(DamperUnderAnEncoder, TakesEnergyFromAVibrationAsADamperDoes) {
  const double q = 55e-6, damping = 1.0, swing_m = 0.003, omega = 2 * std::numbers::pi * 16.0;
  Damper damper(damping, q);
  damper.reset({0, 0, 0.01});
  double taken_j = 0.0, last_m = 0.01;
  Vec3 held{};
  for (int i = 1; i <= 2000; ++i) {
    const double stretch_m = 0.01 + swing_m * std::sin(omega * i * dt);
    taken_j += damping * held.z * (stretch_m - last_m);
    last_m = stretch_m;
    held = damper.relative_velocity({0, 0, rounded(stretch_m, q)}, {}, dt, k).way_m;
  }
  const double ideal_j = 0.5 * damping * swing_m * swing_m * omega * omega * 2.0;
  EXPECT_GT(taken_j, 0.9 * ideal_j);
  EXPECT_LT(taken_j, 1.02 * ideal_j);
}

TEST(DamperUnderAnEncoder, FollowsASteadyMotionAtAnyRateOfTicks) {
  for (const double tick_s : {2e-3, 1e-3, 2.5e-4, 2e-5}) {
    Damper damper(1.0, 20e-6);
    damper.reset({0, 0, 0.1});
    Vec3 seen;
    const int ticks = static_cast<int>(0.05 / tick_s);
    for (int i = 1; i <= ticks; ++i)
      seen = damper.relative_velocity({0, 0, 0.1 + rounded(0.05 * i * tick_s, 20e-6)}, {}, tick_s, k).way_m;
    EXPECT_NEAR(seen.z, 0.05, 20e-6 / window_s(1.0) * (1 + 1e-6)) << tick_s;
  }
}

TEST(DamperUnderAnEncoder, AReleaseIsNoMotion) {
  Damper damper(1.0, 55e-6);
  damper.reset({0, 0, 0.005});
  for (int i = 0; i < 10; ++i) damper.relative_velocity({0, 0, 0.005}, {}, dt, k).way_m;
  for (int i = 0; i < 10; ++i) {
    const Vec3 released = i == 0 ? Vec3{0, 0, -0.0049} : Vec3{};
    EXPECT_NEAR(norm(damper.relative_velocity({0, 0, 0.0001}, {released, {}}, dt, k).way_m), 0.0, 1e-12) << i;
  }
}

TEST(DamperUnderAnEncoder, NeverExceedsTheLargerOfAFifthNewtonAndHalfTheSpring) {
  std::mt19937 engine(7);
  const auto in = [&](double size) { return size * (static_cast<double>(engine()) / 2147483648.0 - 1.0); };
  Damper damper(2.0, 55e-6);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 stretch{in(0.01), in(0.01), in(0.01)};
    const Vec3 seen = damper.relative_velocity({stretch, {}}, {}, dt, k).way_m;
    EXPECT_LE(2.0 * norm(seen), std::max(0.2, 0.5 * k * norm(stretch)) * (1 + 1e-12));
  }
}

TEST(DamperUnderAnEncoder, IsFiniteForEverything) {
  std::mt19937_64 engine(11);
  const double odd[] = {0.0,
                        1.0,
                        1e-300,
                        1e300,
                        std::numeric_limits<double>::max(),
                        std::numeric_limits<double>::infinity(),
                        std::numeric_limits<double>::quiet_NaN(),
                        -1e300,
                        -1e-3};
  const auto any = [&] { return odd[engine() % std::size(odd)]; };
  for (const double q : {1e-300, 55e-6, 1e300}) {
    Damper damper(1.0, q);
    for (int i = 0; i < 50000; ++i) {
      const double tick_s = engine() % 3 ? dt : 1e-12;
      EXPECT_TRUE(is_finite(damper.relative_velocity({any(), any(), any()}, {}, tick_s, k).way_m)) << q << " " << i;
    }
  }
}

}  // namespace damper_test
}  // namespace palpa
