// Closed forms of balances: to the last bit without a pull, to rounding elsewhere.
#include <gtest/gtest.h>

#include <cmath>

#include "palpa/solver/solver.h"
#include "tests/solver/solved.h"

namespace palpa {
namespace closed_form_test {

using test::Problem;
using test::Random;

Balance solve(Solver& solver, const Problem& problem) {
  PrimitiveSet set(8);
  return test::solved(problem, solver, set).balance;
}

// The damper takes a proxy that differs from the probe in any bit for a held proxy.
TEST(ClosedForm, WhereNothingPullsIsTheProbeToTheLastBit) {
  Random random(21);
  Solver solver(8);
  for (int i = 0; i < 5000; ++i) {
    Problem problem = test::random_problem(random, 1 + random.below(6), false);
    for (Primitive& p : problem.primitives) {
      if (p.kind == PrimitiveKind::directed) p.kind = PrimitiveKind::point;
      p.position_m = problem.start_m;
      if (p.kind == PrimitiveKind::plane && random.below(2) == 0) {  // left on its free side
        if (dot(p.direction, problem.probe_m - p.position_m) < 0) p.direction = -p.direction;
      } else {
        p.strength_n = 0.0;
      }
    }
    const Balance balance = solve(solver, problem);
    EXPECT_EQ(balance.position_m, problem.probe_m);
    EXPECT_LE(balance.error_bound_m, 1e-10);
    for (const Vec3& force : solver.forces_n()) EXPECT_EQ(norm(force), 0.0);
  }
}

// One primitive, or a surface with its friction, in long double against the solver.
TEST(ClosedForm, IsExactToRoundingAndSaysSo) {
  Random random(22);
  for (int i = 0; i < 5000; ++i) {
    Problem problem = test::random_problem(random, 1, i % 2 == 1);
    Primitive& p = problem.primitives[0];
    if (p.kind == PrimitiveKind::directed) continue;
    const bool surface = p.kind == PrimitiveKind::plane && i % 3 == 0;
    if (surface) {
      Primitive friction = p;
      friction.kind = PrimitiveKind::line, friction.id.slot = 1, friction.strength_n *= 0.3;
      problem.primitives.push_back(friction);
    }
    Solver solver(8);
    const Balance balance = solve(solver, problem);
    EXPECT_EQ(balance.stage, 1);
    EXPECT_EQ(balance.iterations, 1);
    EXPECT_LE(balance.error_bound_m, 1e-15);

    long double x[3] = {problem.probe_m.x, problem.probe_m.y, problem.probe_m.z};
    for (const Primitive& q : problem.primitives) {
      const long double n[3] = {q.direction.x, q.direction.y, q.direction.z};
      const long double a[3] = {q.position_m.x, q.position_m.y, q.position_m.z};
      long double r[3], along = 0.0L, squared = 0.0L;
      for (int c = 0; c < 3; ++c) r[c] = a[c] - x[c], along += n[c] * r[c];
      if (q.kind == PrimitiveKind::plane) {
        for (int c = 0; c < 3; ++c) r[c] = std::max(0.0L, along) * n[c];
      } else if (q.kind == PrimitiveKind::line) {
        for (int c = 0; c < 3; ++c) r[c] -= along * n[c];
      }
      for (int c = 0; c < 3; ++c) squared += r[c] * r[c];
      const long double k = problem.stiffness_n_per_m, asked = k * std::sqrt(squared), s = q.strength_n;
      const long double gamma = q.drag_ns_per_m / (k * problem.time_step_s);
      const long double given = asked <= s ? asked : s + gamma * (asked - s) / (1 + gamma);
      for (int c = 0; c < 3 && asked > 0; ++c) x[c] += given / asked * r[c];
    }
    const long double dx = x[0] - balance.position_m.x, dy = x[1] - balance.position_m.y, dz = x[2] - balance.position_m.z;
    EXPECT_LE(std::sqrt(dx * dx + dy * dy + dz * dz), balance.error_bound_m);
  }
}

// A drag once pulled fast had a force thousands of times the next balance's, which must not keep its rounding.
TEST(ClosedForm, KeepsNoRoundingOfAWarmStart) {
  Random random(23);
  for (int i = 0; i < 5000; ++i) {
    Problem problem = test::random_problem(random, 1, true);
    Primitive& p = problem.primitives[0];
    if (p.kind == PrimitiveKind::directed) continue;
    problem.start_m = p.position_m = {};
    p.strength_n = random.uniform(0, 0.01);
    p.drag_ns_per_m = random.uniform(0, 20);
    Problem fast = problem;
    fast.probe_m = random.in_cube(0.05);
    problem.probe_m = std::pow(10.0, random.uniform(-7, -3)) * random.direction();
    Solver cold(8), warm(8);
    solve(warm, fast);
    const Balance after = solve(warm, problem), alone = solve(cold, problem);
    EXPECT_LE(distance(after.position_m, alone.position_m), after.error_bound_m + alone.error_bound_m);
  }
}

}  // namespace closed_form_test
}  // namespace palpa
