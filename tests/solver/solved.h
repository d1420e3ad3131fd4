// A problem solved once, with all results that the solver's tests check.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <initializer_list>
#include <ostream>
#include <vector>

#include "palpa/solver/solver.h"
#include "tests/solver/problem_families.h"

namespace palpa::test {

struct Solved {
  Balance balance;
  std::vector<Vec3> forces_n;
  Vec3 remainder_m;  ///< rounding error of the position
};

inline Solved solved(const Problem& problem, Solver& solver, PrimitiveSet& set) {
  fill(set, problem);
  EXPECT_EQ(set.dropped(), 0);
  Solved result;
  result.balance = solver.solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
  result.forces_n.assign(solver.forces_n().begin(), solver.forces_n().end());
  result.remainder_m = solver.remainder_m();
  return result;
}

inline Solved solved(const Problem& problem) {
  const std::size_t capacity = std::max<std::size_t>(1, problem.primitives.size());
  Solver solver(capacity);
  PrimitiveSet set(capacity);
  return solved(problem, solver, set);
}

/// A reproducible problem: Random random(seed); family.make(random, n, drags).
struct Recipe {
  const Family& family;
  int n;
  bool drags;
  std::uint64_t seed;
  Problem problem() const {
    Random random(seed);
    return family.make(random, n, drags);
  }
  friend std::ostream& operator<<(std::ostream& out, const Recipe& r) {
    return out << r.family.name << (r.drags ? " with drags" : "") << ", n = " << r.n << ", seed " << r.seed;
  }
};

/// Calls `check(recipe)` for `repetitions` problems of each size.
template <class Check>
void for_each_problem(const Family& family, bool drags, std::initializer_list<int> sizes, int repetitions, Check check) {
  for (const int n : sizes) {
    const std::uint64_t first = static_cast<std::uint64_t>(1'000'003) * static_cast<std::uint64_t>(n) + 1;
    for (int i = 0; i < repetitions; ++i) check(Recipe{family, n, drags, first + static_cast<std::uint64_t>(i)});
  }
}

}  // namespace palpa::test
