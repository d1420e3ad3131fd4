// Pending motion: no pull, fade, no injected energy, return.
#include "palpa/session/lag_compensator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <type_traits>

#include "tests/solver/random_problems.h"

namespace palpa {
namespace slack_test {

constexpr double k = 500.0;

static_assert(std::is_trivially_copyable_v<LagCompensator>);  // part of a session's StateArena

// Of a tool: the laws hold for a point as its special case.
Motion motion(test::Random& random, double size_m) { return {random.in_cube(size_m), random.in_cube(size_m)}; }

class Felt : public LagCompensator {
 public:
  Motion applied_extension_m(const Motion& stretch_m, const Motion& to_followed_m, double waits_s,
                           const Motion& probe_step_m) noexcept {
    return last_m_ = LagCompensator::applied_extension_m(stretch_m, to_followed_m, waits_s, last_m_ - probe_step_m);
  }
  /// Before any pending motion.
  Motion begin(const Motion& stretch_m) { return last_m_ = stretch_m; }

 private:
  Motion last_m_;
};

// With the whole spring paid the applied extension is the whole, to the bit.
TEST(LagCompensator, IsNoneWhereAllIsPaid) {
  test::Random random(1);
  LagCompensator slack;
  for (int i = 0; i < 1000; ++i) {
    const Motion stretch_m = motion(random, 0.02);
    EXPECT_EQ(slack.applied_extension_m(stretch_m, stretch_m, 0.0, random.uniform(1.0, 3.0) * (1.0 + 1e-15) * stretch_m),
              stretch_m);
    EXPECT_FALSE(slack.any());
  }
}

// The hand runs away from a stopped proxy: the applied force stays that of the last processed position, and fades.
TEST(LagCompensator, DoesNotPull) {
  Felt slack;
  const Motion followed_m{0, 0, 0.002}, step_m{0.0002, 0, -0.0001};
  Motion probe_m, applied_m = slack.begin(followed_m);
  double last_m = length(applied_m);
  for (int tick = 1; tick <= 60; ++tick) {
    probe_m += step_m;
    applied_m = slack.applied_extension_m(followed_m - probe_m, followed_m, 1e-3 * tick, step_m);
    EXPECT_LE(length(applied_m), last_m);
    EXPECT_NEAR(length(applied_m), std::max(0.0, 1.0 - tick / 50.0) * length(followed_m), 1e-15);
    EXPECT_EQ(slack.withheld_m(), followed_m - probe_m - applied_m);
    last_m = length(applied_m);
  }
  EXPECT_TRUE(LagCompensator::has_faded(0.05));
  EXPECT_FALSE(LagCompensator::has_faded(0.049));
}

// For any proxy and any hand: no tick injects more than the hold of a spring's force does.
TEST(LagCompensator, BringsInNothing) {
  test::Random random(2);
  for (int run = 0; run < 200; ++run) {
    Felt slack;
    Motion proxy_m = motion(random, 0.01), probe_m = motion(random, 0.01);
    Motion applied_m = slack.begin(proxy_m - probe_m);
    double waits_s = 0.0;
    for (int tick = 0; tick < 300; ++tick) {
      const Motion step_m = motion(random, 0.001);
      probe_m += step_m;
      proxy_m += motion(random, 0.003);
      waits_s = random.uniform(0, 1) < 0.9 ? random.uniform(1e-3, 0.06) : 0.0;
      const Motion before_m = applied_m;
      const Motion followed_m = waits_s > 0.0 ? probe_m + motion(random, 0.02) : probe_m;
      applied_m = slack.applied_extension_m(proxy_m - probe_m, proxy_m - followed_m, waits_s, step_m);
      const double work_j = k * dot(before_m, step_m);
      const double lost_j = 0.5 * k * (length_squared(before_m) - length_squared(applied_m));
      ASSERT_LE(work_j, lost_j + 0.5 * k * length_squared(step_m) + 1e-15);
    }
  }
}

// After pending motion the hand's own motion restores the withheld force, at once and no faster, beside the timed return.
TEST(LagCompensator, IsMadeGoodByTheHandsOwnMotion) {
  Felt slack;
  const Motion wall_m{};  // the proxy is held here, for any hand
  Motion probe_m{0, 0, -0.004};
  for (int tick = 0; tick < 60; ++tick) slack.applied_extension_m(wall_m - probe_m, {}, 1e-3 * tick, {});
  EXPECT_EQ(slack.applied_extension_m(wall_m - probe_m, wall_m - probe_m, 0.0, {}), Motion{})
      << "a still hand makes nothing good";
  for (int tick = 1; tick <= 100; ++tick) {  // pressed deeper, the force grows from there on
    probe_m.way_m.z -= 1e-5;
    EXPECT_NEAR(slack.applied_extension_m(wall_m - probe_m, wall_m - probe_m, 0.0, {0, 0, -1e-5}).way_m.z, 1e-5 * tick, 1e-15);
  }
  for (int tick = 1; tick <= 200; ++tick) {  // drawn back, it falls to 0, but never pulls into the wall
    probe_m.way_m.z += 1e-5;
    EXPECT_NEAR(slack.applied_extension_m(wall_m - probe_m, wall_m - probe_m, 0.0, {0, 0, 1e-5}).way_m.z,
                1e-5 * std::max(0, 100 - tick), 1e-15);
  }
  EXPECT_EQ(slack.applied_extension_m({}, {}, 0.0, {0, 0, 1e-5}), Motion{}) << "free";
  const Motion pressed_m{0, 0, 0.001};
  EXPECT_EQ(slack.applied_extension_m(pressed_m, pressed_m, 0.0, {0, 0, -1e-3}), pressed_m) << "as if nothing had waited";
}

// Returned whole, 20 ms after the last pending tick or up to a tick earlier, in equal steps.
TEST(LagCompensator, IsGivenBackInTime) {
  for (const double rate_hz : {20.0, 100.0, 150.0, 250.0, 333.0, 1000.0, 4000.0, 10000.0}) {
    const double dt_s = 1.0 / rate_hz;
    const Motion stretch_m{0.001, -0.002, 0.003};
    LagCompensator slack;
    slack.applied_extension_m(stretch_m, {}, dt_s, {});
    ASSERT_EQ(slack.withheld_m(), stretch_m);
    double passed_s = 0.0, largest_m = 0.0;
    int ticks = 0;
    Motion applied_m;
    while (slack.any() && ticks < 1000) {
      slack.applied_extension_m(stretch_m, stretch_m, 0.0, applied_m);
      const Motion back_m = slack.give_back_m(dt_s, 1.0);
      applied_m = stretch_m - slack.withheld_m();
      largest_m = std::max(largest_m, length(back_m));
      passed_s += dt_s;
      ++ticks;
    }
    EXPECT_EQ(applied_m, stretch_m) << rate_hz;
    EXPECT_LE(passed_s, std::max(0.02 * (1 + 1e-9), dt_s)) << rate_hz;
    EXPECT_GT(passed_s, 0.02 - dt_s) << rate_hz;
    EXPECT_NEAR(largest_m, length(stretch_m) / ticks, 1e-12) << rate_hz;
  }
}

// For ticks of any lengths, any hand and any proxy: nothing is left after 20 ms without pending motion.
TEST(LagCompensator, IsGivenBackInTimeHoweverTicksDiffer) {
  test::Random random(6);
  for (int run = 0; run < 300; ++run) {
    LagCompensator slack;
    Motion probe_m = motion(random, 0.01), proxy_m = motion(random, 0.01), applied_m;
    slack.applied_extension_m(proxy_m - probe_m, {}, 0.01, {});
    for (double passed_s = 0.0; passed_s < 0.02;) {
      const double dt_s = std::min(random.uniform(1e-5, 0.008), 0.02 - passed_s);
      const Motion step_m = motion(random, 0.002);
      probe_m += step_m;
      proxy_m += motion(random, 0.002);
      slack.applied_extension_m(proxy_m - probe_m, proxy_m - probe_m, 0.0, applied_m - step_m);
      slack.give_back_m(dt_s, 1.0);
      applied_m = proxy_m - probe_m - slack.withheld_m();
      passed_s += dt_s;
    }
    EXPECT_FALSE(slack.any());
  }
}

// Never above the allowed rate, and still to the end.
TEST(LagCompensator, IsGivenBackByNoMoreThanIsAllowed) {
  const Motion stretch_m{0.03, -0.04, 0.0};
  LagCompensator slack;
  slack.applied_extension_m(stretch_m, {}, 1e-3, {});
  Motion applied_m;
  int ticks = 0;
  for (; slack.any() && ticks < 1000; ++ticks) {
    slack.applied_extension_m(stretch_m, stretch_m, 0.0, applied_m);
    EXPECT_LE(length(slack.give_back_m(1e-3, 1e-3)), 1e-3 * (1 + 1e-12));
    applied_m = stretch_m - slack.withheld_m();
  }
  EXPECT_EQ(applied_m, stretch_m);
  EXPECT_NEAR(ticks, 50, 1);
}

// A tick injects its return beside the hold's energy, and the spring stores it.
TEST(LagCompensator, BringsInWhatItGivesBackAndNoMore) {
  test::Random random(7);
  for (int run = 0; run < 200; ++run) {
    LagCompensator slack;
    Motion proxy_m = motion(random, 0.01), probe_m = motion(random, 0.01), applied_m = proxy_m - probe_m;
    for (int tick = 0; tick < 300; ++tick) {
      const Motion step_m = motion(random, 0.001), before_m = applied_m;
      probe_m += step_m;
      proxy_m += motion(random, 0.003);
      const Motion stretch_m = proxy_m - probe_m;
      const double waits_s = random.uniform(0, 1) < 0.3 ? random.uniform(1e-3, 0.06) : 0.0;
      const Motion to_followed_m = waits_s > 0.0 ? stretch_m + motion(random, 0.02) : stretch_m;
      const Motion own_m = slack.applied_extension_m(stretch_m, to_followed_m, waits_s, before_m - step_m);
      if (waits_s == 0.0) slack.give_back_m(random.uniform(1e-4, 0.01), random.uniform(0, 0.005));
      applied_m = stretch_m - slack.withheld_m();
      const double given_back_j = 0.5 * k * (length_squared(applied_m) - length_squared(own_m));
      ASSERT_GE(given_back_j, -1e-15);
      const double lost_j = 0.5 * k * (length_squared(before_m) - length_squared(applied_m));
      ASSERT_LE(k * dot(before_m, step_m), lost_j + 0.5 * k * length_squared(step_m) + given_back_j + 1e-15);
      if (waits_s == 0.0) {
        ASSERT_LE(length(applied_m), length(stretch_m) * (1 + 1e-12));
      } else {
        ASSERT_NEAR(given_back_j, 0.0, 1e-15);
      }
    }
  }
}

}  // namespace slack_test
}  // namespace palpa
