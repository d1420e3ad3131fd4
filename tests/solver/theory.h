// The formulas of docs/theory.md in their written form, for the tests of its statements.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "palpa/solver/solver.h"
#include "tests/solver/random_problems.h"

namespace palpa::test::theory {

inline constexpr double tick_s = 1e-3;

struct Solved {
  Balance balance;
  std::vector<Vec3> forces_n;
};

inline Solved solve(const Problem& problem) {
  const std::size_t capacity = std::max<std::size_t>(1, problem.primitives.size());
  PrimitiveSet set(capacity);
  fill(set, problem);
  EXPECT_EQ(set.dropped(), 0);
  Solver solver(capacity);
  const Balance balance = solver.solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
  return {balance, {solver.forces_n().begin(), solver.forces_n().end()}};
}

inline Vec3 directed_sum(const Problem& problem) {
  Vec3 sum;
  for (const Primitive& p : problem.primitives) {
    if (p.kind == PrimitiveKind::directed) sum += p.strength_n * p.direction;
  }
  return sum;
}

inline double drag_stiffness(const Primitive& p, const Problem& problem) { return p.drag_ns_per_m / problem.time_step_s; }

// φ(r) = s|r| + C/2 |r|²
inline double dissipation(const Primitive& p, const Problem& problem, const Vec3& x) {
  const double r = norm(residual(p, x));
  return p.strength_n * r + 0.5 * drag_stiffness(p, problem) * r * r;
}

inline double dissipation(const Problem& problem, const Vec3& x) {
  double sum = 0.0;
  for (const Primitive& p : problem.primitives) sum += dissipation(p, problem, x);
  return sum;
}

inline double spring(const Problem& problem, const Vec3& x) {
  return 0.5 * problem.stiffness_n_per_m * norm_squared(x - problem.probe_m);
}

// E(x), with the directed forces' potential counted from the start.
inline double energy(const Problem& problem, const Vec3& x) {
  return spring(problem, x) - dot(directed_sum(problem), x - problem.start_m) + dissipation(problem, x);
}

// φ*(u) of an admissible force.
inline double conjugate(const Primitive& p, const Problem& problem, const Vec3& u) {
  const double excess = std::max(0.0, norm(u) - p.strength_n);
  return p.drag_ns_per_m > 0.0 ? 0.5 * excess * excess / drag_stiffness(p, problem) : 0.0;
}

// A random admissible force: in the span, and beyond the strength only with a drag.
inline Vec3 some_force(Random& random, const Primitive& p) {
  const double length = random.uniform(0.0, p.drag_ns_per_m > 0.0 ? 2.0 * p.strength_n + 0.1 : p.strength_n);
  if (p.kind == PrimitiveKind::plane) return length * p.direction;
  const Vec3 any = random.direction();
  return length * (p.kind == PrimitiveKind::line ? normalized(any - dot(p.direction, any) * p.direction) : any);
}

inline std::vector<Vec3> some_forces(Random& random, const Problem& problem) {
  std::vector<Vec3> forces;
  for (const Primitive& p : problem.primitives)
    forces.push_back(p.kind == PrimitiveKind::directed ? p.strength_n * p.direction : some_force(random, p));
  return forces;
}

inline Vec3 total(const std::vector<Vec3>& forces) {
  Vec3 sum;
  for (const Vec3& u : forces) sum += u;
  return sum;
}

// The dual function: the least of k/2 |x − p|² − d·x + Σ u·R(x) − φ*(u) over x.
inline double dual(const Problem& problem, const std::vector<Vec3>& forces) {
  const Vec3 F = total(forces);
  double value = -0.5 * norm_squared(F) / problem.stiffness_n_per_m - dot(F, problem.probe_m - problem.start_m);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    if (p.kind != PrimitiveKind::directed)
      value += dot(forces[i], p.position_m - problem.start_m) - conjugate(p, problem, forces[i]);
  }
  return value;
}

// ε = Σ φ(r) + φ*(u) − u·R and ρ = |k (x − p) − Σ forces|, in their written form.
inline double gap(const Problem& problem, const std::vector<Vec3>& forces, const Vec3& x) {
  double sum = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    sum += dissipation(p, problem, x) + conjugate(p, problem, forces[i]) - dot(forces[i], p.position_m - x);
  }
  return sum;
}

inline double force_left(const Problem& problem, const std::vector<Vec3>& forces, const Vec3& x) {
  return norm(problem.stiffness_n_per_m * (x - problem.probe_m) - total(forces));
}

// Largest change of E between the computed balance and the exact one.
inline double energy_slack(const Problem& problem, const Balance& balance) {
  double slope = problem.stiffness_n_per_m * (distance(balance.position_m, problem.probe_m) + balance.error_bound_m);
  for (const Primitive& p : problem.primitives)
    slope += p.strength_n + drag_stiffness(p, problem) * (norm(residual(p, balance.position_m)) + balance.error_bound_m);
  return slope * balance.error_bound_m + 1e-16;
}

// Every point, line and plane goes through `at`; no directed forces.
inline Problem problem_through(Random& random, const Vec3& at, int n, bool drags) {
  Problem problem = random_problem(random, n, false);
  problem.start_m = at;
  for (Primitive& p : problem.primitives) {
    if (p.kind == PrimitiveKind::directed) p.kind = PrimitiveKind::point;
    p.position_m = at;
    if (drags && random.below(2) == 0) p.drag_ns_per_m = random.uniform(0, 20);
  }
  return problem;
}

}  // namespace palpa::test::theory
