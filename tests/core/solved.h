// A problem solved once, with all that the tests of the solver look at.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include "palpa/core/solver.h"
#include "tests/core/problem_families.h"

namespace palpa::test {

struct Solved {
  Balance balance;
  std::vector<Vec3> forces_n;
  Vec3 remainder_m;  ///< what position_m lost when it was rounded
};

/// Of a solver that proves its balance for a sum of two doubles; zero of one that does not.
template <class AnySolver>
Vec3 remainder_m(const AnySolver& solver) {
  if constexpr (requires { solver.remainder_m(); }) {
    return solver.remainder_m();
  } else {
    return {};
  }
}

inline Solved solved(const Problem& problem, Solver& solver, PrimitiveSet& set) {
  fill(set, problem);
  EXPECT_EQ(set.dropped(), 0);
  Solved result;
  result.balance = solver.solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
  result.forces_n.assign(solver.forces_n().begin(), solver.forces_n().end());
  result.remainder_m = remainder_m(solver);
  return result;
}

/// From a cold start.
inline Solved solved(const Problem& problem) {
  const std::size_t capacity = std::max<std::size_t>(1, problem.primitives.size());
  Solver solver(capacity);
  PrimitiveSet set(capacity);
  return solved(problem, solver, set);
}

/// A problem that can be made again: Random random(seed); family.make(random, n, drags).
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

/// One test for each family, with and without drags.
class OverFamilies : public testing::TestWithParam<std::tuple<std::size_t, bool>> {
 protected:
  const Family& family() const { return families()[std::get<0>(GetParam())]; }
  bool drags() const { return std::get<1>(GetParam()); }

  /// Calls `check(recipe)` for `repetitions` problems of each size.
  template <class Check>
  void for_each_problem(std::initializer_list<int> sizes, int repetitions, Check check) const {
    for (const int n : sizes) {
      for (int i = 0; i < repetitions && !HasFatalFailure(); ++i) {
        check(
            Recipe{family(), n, drags(),
                   static_cast<std::uint64_t>(1'000'003) * static_cast<std::uint64_t>(n) + static_cast<std::uint64_t>(i) + 1});
      }
    }
  }
};

inline std::string name_of_family(const testing::TestParamInfo<std::tuple<std::size_t, bool>>& info) {
  return std::string(families()[std::get<0>(info.param)].name) + (std::get<1>(info.param) ? "_with_drags" : "");
}

inline auto every_family() { return testing::Combine(testing::Range<std::size_t>(0, families().size()), testing::Bool()); }

}  // namespace palpa::test
