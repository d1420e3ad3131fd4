// Statements of docs/theory.md on sequences of balances: slope of the force, change, energy.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/solver/theory.h"

namespace palpa {
namespace passivity_test {

using namespace test::theory;
using test::Problem;
using test::Random;
using test::random_problem;

TEST(Force, IsMonotoneInTheProbeWithASlopeUpToTheStiffness) {
  Random random(108);
  for (int i = 0; i < 10000; ++i) {
    Problem problem = random_problem(random, 1 + random.below(6), i % 2 == 1);
    const double k = problem.stiffness_n_per_m;
    const Balance first = solve(problem).balance;
    const Vec3 p = problem.probe_m;
    problem.probe_m += std::pow(10.0, random.uniform(-4, 0)) * random.in_cube(0.004);
    const Balance second = solve(problem).balance;
    const Vec3 dp = problem.probe_m - p;
    const Vec3 df = k * ((second.position_m - problem.probe_m) - (first.position_m - p));
    const double slack_n = k * (first.error_bound_m + second.error_bound_m) + 1e-15 * k;
    EXPECT_LE(dot(df, dp), slack_n * norm(dp));
    EXPECT_GE(dot(df, dp), -k * norm_squared(dp) - slack_n * norm(dp));
    EXPECT_LE(norm_squared(df), -k * dot(df, dp) + slack_n * (k * norm(dp) + 2.0 * norm(df) + slack_n));
    EXPECT_LE(norm(df), k * norm(dp) + slack_n);
  }
}

TEST(Balance, MovesByAtMostTheChangeOfStrengthsAndDirectedForcesOverTheStiffness) {
  Random random(109);
  for (int i = 0; i < 10000; ++i) {
    Problem problem = random_problem(random, 1 + random.below(6), i % 2 == 1);
    const Balance first = solve(problem).balance;
    double changed_n = 0.0;
    for (Primitive& p : problem.primitives) {
      const Vec3 before = p.strength_n * p.direction;
      const double strength_n = p.strength_n;
      p.strength_n *= random.uniform(0, 2);
      if (p.kind == PrimitiveKind::directed) p.direction = random.direction();
      changed_n += p.kind == PrimitiveKind::directed ? distance(p.strength_n * p.direction, before)
                                                     : std::abs(p.strength_n - strength_n);
    }
    const Balance second = solve(problem).balance;
    EXPECT_LE(distance(first.position_m, second.position_m),
              changed_n / problem.stiffness_n_per_m + first.error_bound_m + second.error_bound_m + 1e-16);
  }
}

// Limit of non-expansiveness: when primitives change, a still hand's proxy may move.
TEST(Balance, OfAStillHandMovesWhereItsPrimitivesDo) {
  const Primitive plane{PrimitiveKind::plane, {}, {}, {0, 0, 1}, 2.0};
  Problem problem{{plane}, {}, {0, 0, -0.002}, 500, tick_s};
  const Vec3 held = solve(problem).balance.position_m;
  problem.start_m = held;
  problem.primitives[0].direction = normalized({1, 0, 1});
  problem.primitives[0].strength_n = 0.1;
  const Vec3 released_m = solve(problem).balance.position_m;
  EXPECT_NEAR(distance(held, released_m), 0.002, 0.1 / 500 + 1e-9);
}

// The map x ← p + d(x)/k of a still hand: at rest where |∂d/∂x| < k, oscillating above.
TEST(DirectedForce, ComesToRestOnlyWhereItsSlopeIsBelowTheStiffness) {
  constexpr double k = 500;
  for (const double share : {0.5, 0.9, 1.1, 2.0}) {  // of k
    double x = 1e-4, last_step = 0.0, step = 0.0;
    for (int i = 0; i < 30; ++i) {
      const double force_n = -share * k * x;  // towards zero, sampled at the proxy
      Problem problem{
          {{PrimitiveKind::directed, {}, {}, {force_n < 0 ? -1.0 : 1.0, 0, 0}, std::abs(force_n)}}, {}, {}, k, tick_s};
      problem.start_m = {x, 0, 0};
      last_step = step;
      step = solve(problem).balance.position_m.x - x;
      x += step;
    }
    EXPECT_LT(step * last_step, 0.0) << "to and fro";
    EXPECT_NEAR(std::abs(step / last_step), share, 1e-9);
  }
}

// Theorem A: fixed primitives; M is the least energy for a probe. Its slope is −f.
TEST(Passivity, OfFixedPrimitivesLeaksAtMostHalfTheStiffnessTimesTheStepSquared) {
  Random random(110);
  for (int i = 0; i < 2000; ++i) {
    Problem problem = random_problem(random, 1 + random.below(6), false);
    const double k = problem.stiffness_n_per_m;
    Balance now = solve(problem).balance;
    for (int step = 0; step < 10; ++step) {
      const Problem before = problem;
      problem.probe_m += std::pow(10.0, random.uniform(-3, 0)) * random.in_cube(0.004);
      const Vec3 dp = problem.probe_m - before.probe_m;
      const Balance next = solve(problem).balance;
      const double work_j = k * dot(now.position_m - before.probe_m, dp);
      const double released_j = energy(before, now.position_m) - energy(problem, next.position_m);
      const double slack_j = energy_slack(before, now) + energy_slack(problem, next) + k * now.error_bound_m * norm(dp);
      EXPECT_LE(work_j, released_j + 0.5 * k * norm_squared(dp) + slack_j);
      EXPECT_GE(work_j, released_j - slack_j);  // nor more work taken than stored
      now = next;
    }
  }
}

// A round trip: a device that damps with b = kT/2 takes out at least the energy given by fixed primitives.
TEST(Passivity, OfFixedPrimitivesOverAClosedPathNeedsNoMoreThanHalfTheStiffnessTimesTheTick) {
  Random random(111);
  for (int i = 0; i < 200; ++i) {
    Problem problem = random_problem(random, 1 + random.below(6), false);
    const double k = problem.stiffness_n_per_m;
    const Vec3 middle = problem.probe_m, a = random.in_cube(0.004), b = random.in_cube(0.004);
    constexpr int steps = 100;
    const auto probe_at = [&](int n) {
      const double turn = 2.0 * std::numbers::pi * (n % steps) / steps;
      return middle + std::cos(turn) * a + std::sin(turn) * b;
    };
    double work_j = 0.0, damped_j = 0.0, slack_j = 1e-15;
    for (int n = 0; n < steps; ++n) {
      problem.probe_m = probe_at(n);
      const Balance balance = solve(problem).balance;
      const Vec3 dp = probe_at(n + 1) - probe_at(n);
      work_j += k * dot(balance.position_m - problem.probe_m, dp);
      damped_j += 0.5 * k * norm_squared(dp);  // (kT/2) ∫|v|² dt, the hand's speed constant over a tick: the minimum
      slack_j += k * balance.error_bound_m * norm(dp);
    }
    EXPECT_LE(work_j, damped_j + slack_j);
  }
}

// Theorem B: in every step other primitives, with any direction, strength and drag, all through the proxy.
TEST(Passivity, OfPrimitivesThroughTheProxyLeaksAtMostHalfTheStiffnessTimesTheStepSquared) {
  Random random(112);
  int tight = 0;
  for (int i = 0; i < 500; ++i) {
    const double k = random.uniform(300, 3000);
    Vec3 x = random.in_cube(0.05), p = x;
    for (int step = 0; step < 40; ++step) {
      Problem problem = problem_through(random, x, random.below(6), step % 2 == 1);
      problem.stiffness_n_per_m = k;
      problem.probe_m = p + std::pow(10.0, random.uniform(-3, 0)) * random.in_cube(0.004);
      const Vec3 dp = problem.probe_m - p;
      const Balance next = solve(problem).balance;
      const double work_j = k * dot(x - p, dp);
      const double released_j = 0.5 * k * norm_squared(x - p) - spring(problem, next.position_m);
      const double dissipated_j = dissipation(problem, next.position_m) + 0.5 * k * norm_squared(next.position_m - x);
      const double leak_j = 0.5 * k * norm_squared(dp), slack_j = energy_slack(problem, next);
      EXPECT_LE(work_j, released_j - dissipated_j + leak_j + slack_j);
      if (work_j - released_j > 0.5 * leak_j) ++tight;
      x = next.position_m;
      p = problem.probe_m;
    }
  }
  EXPECT_GT(tight, 100) << "the steps do not come near what is proven";
}

// … and a primitive elsewhere injects at most its strength times its distance; a directed force d·Δx.
TEST(Passivity, OfPrimitivesElsewhereCostsAtMostStrengthTimesDistance) {
  Random random(113);
  int above = 0;
  for (int i = 0; i < 500; ++i) {
    const double k = random.uniform(300, 3000);
    Vec3 x = random.in_cube(0.05), p = x;
    for (int step = 0; step < 40; ++step) {
      Problem problem = random_problem(random, 1 + random.below(5), false);
      const Vec3 shift = x - problem.start_m;
      for (Primitive& primitive : problem.primitives) primitive.position_m += shift;
      problem.start_m = x;
      problem.stiffness_n_per_m = k;
      problem.probe_m = p + 0.1 * random.in_cube(0.004);
      const Vec3 dp = problem.probe_m - p;
      const Balance next = solve(problem).balance;
      const double work_j = k * dot(x - p, dp);
      const double released_j = 0.5 * k * norm_squared(x - p) - spring(problem, next.position_m);
      const double budget_j = dissipation(problem, x) + dot(directed_sum(problem), next.position_m - x);
      const double leak_j = 0.5 * k * norm_squared(dp);
      EXPECT_LE(work_j, released_j + leak_j + budget_j + energy_slack(problem, next));
      if (work_j > released_j + leak_j) ++above;
      x = next.position_m;
      p = problem.probe_m;
    }
  }
  EXPECT_GT(above, 100) << "nothing was brought in, so the budget was not needed";
}

TEST(Passivity, EndsWithDirectedForces) {
  constexpr double k = 500, radius_m = 0.01, force_n = 0.3;
  for (const int steps : {200, 2000}) {
    Vec3 x{radius_m, 0, 0};
    double work_j = 0.0, leak_j = 0.0;
    for (int n = 0; n < steps; ++n) {
      const double turn = 2.0 * std::numbers::pi / steps;
      const Vec3 p{radius_m * std::cos(turn * n), radius_m * std::sin(turn * n), 0};
      const Vec3 to{radius_m * std::cos(turn * (n + 1)), radius_m * std::sin(turn * (n + 1)), 0};
      const Problem problem{{{PrimitiveKind::directed, {}, {}, normalized({-x.y, x.x, 0}), force_n}}, x, p, k, tick_s};
      x = solve(problem).balance.position_m;
      work_j += k * dot(x - p, to - p);
      leak_j += 0.5 * k * norm_squared(to - p);
    }
    EXPECT_GT(work_j, 0.9 * force_n * 2.0 * std::numbers::pi * radius_m);
    EXPECT_GT(work_j, leak_j);
  }
}

}  // namespace passivity_test
}  // namespace palpa
