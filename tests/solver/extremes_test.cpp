// Limits of a set's input: great drags, subnormal strengths, sets too large.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpa/solver/solver.h"
#include "tests/solver/solved.h"

namespace palpa {
namespace extremes_test {

using test::Problem;
using test::Random;

Balance solve(Solver& solver, const Problem& problem) {
  PrimitiveSet set(8);
  return test::solved(problem, solver, set).balance;
}

TEST(Extremes, GreatDragsAreBalanced) {
  Random random(31);
  Solver solver(8);
  for (const double gamma : {1e6, 1e10, 1e13, 1e16}) {
    for (int i = 0; i < 500; ++i) {
      Problem problem = test::random_problem(random, 2 + random.below(4), false);
      problem.time_step_s = 1e-15;
      for (Primitive& p : problem.primitives) {
        if (p.kind == PrimitiveKind::directed || random.below(2) == 0) continue;
        p.position_m = problem.start_m;
        p.drag_ns_per_m = std::min(1e9, gamma * random.uniform(0.5, 2) * problem.stiffness_n_per_m * problem.time_step_s);
      }
      EXPECT_EQ(solve(solver, problem).status, BalanceStatus::exact) << "gamma " << gamma << " problem " << i;
    }
  }
}

// A sub-step of length 0 is bad input; a double's shortest is not.
TEST(Extremes, AStepTooShortForADragIsAsGoodAsTheShortest) {
  Random random(33);
  Solver solver(8);
  for (int i = 0; i < 200; ++i) {
    Problem problem = test::random_problem(random, 1 + random.below(4), true);
    problem.time_step_s = shortest_time_s;
    const Balance shortest = solve(solver, problem);
    for (const double shorter_s : {1e-16, 1e-100, 5e-324}) {
      problem.time_step_s = shorter_s;
      const Balance balance = solve(solver, problem);
      EXPECT_EQ(balance.status, shortest.status);
      EXPECT_LE(distance(balance.position_m, shortest.position_m), balance.error_bound_m + shortest.error_bound_m);
    }
  }
}

TEST(Extremes, StrengthsThatVanishPullNothing) {
  Problem problem{{}, {}, {0.001, 0.002, -0.003}, 800, 1e-3};
  for (const PrimitiveKind kind : {PrimitiveKind::point, PrimitiveKind::line, PrimitiveKind::plane, PrimitiveKind::point}) {
    const Vec3 direction = kind == PrimitiveKind::point ? Vec3{} : Vec3{0, 0, 1};
    problem.primitives.push_back({kind, {0, static_cast<std::uint16_t>(problem.primitives.size())}, {}, direction, 1e-310, 0});
  }
  Solver solver(8);
  const Balance moved = solve(solver, problem);
  EXPECT_EQ(moved.status, BalanceStatus::exact);
  EXPECT_LE(distance(moved.position_m, problem.probe_m), moved.error_bound_m);
  problem.probe_m = {};
  const Balance still = solve(solver, problem);
  EXPECT_EQ(still.status, BalanceStatus::exact);
  EXPECT_EQ(still.position_m, Vec3{});
}

// Balance and forces are of one iterate on every path of the solver.
TEST(Extremes, ForcesBelongToTheBalanceAlsoWhereItIsCapped) {
  Random random(32);
  for (int i = 0; i < 3000; ++i) {
    Problem problem = test::random_problem(random, 3 + random.below(5), i % 2 == 0);
    problem.stiffness_n_per_m = std::pow(10.0, random.uniform(0, 3));
    for (Primitive& p : problem.primitives) p.strength_n *= std::pow(10.0, random.uniform(-4, 2));
    Solver solver(8);
    const Balance balance = solve(solver, problem);
    Vec3 left = -problem.stiffness_n_per_m * ((balance.position_m - problem.probe_m) + solver.remainder_m());
    double size = norm(left);
    for (const Vec3& force : solver.forces_n()) left += force, size += norm(force);
    EXPECT_LE(norm(left), 2.0 * problem.stiffness_n_per_m * balance.error_bound_m + 1e-13 * size) << "problem " << i;
  }
}

#ifdef NDEBUG
TEST(Extremes, ASetLargerThanTheCapacityIsRefused) {
  Random random(33);
  Solver solver(2);
  const Problem problem = test::random_problem(random, 3, false);
  const Balance balance = solve(solver, problem);
  EXPECT_EQ(balance.status, BalanceStatus::bad_input);
  EXPECT_EQ(balance.position_m, problem.start_m);
}
#endif

TEST(Bound, ProvesNothingWithoutAStiffnessOrATime) {
  Random random(34);
  Problem problem = test::random_problem(random, 2, false);
  problem.primitives[0] = {PrimitiveKind::point, {}, problem.start_m, {}, 1.0, 2.0};
  const std::vector<Vec3> forces(2);
  const auto bound = [&](double k, double T) {
    return error_bound_m(problem.primitives, forces, problem.probe_m, problem.probe_m, k, T);
  };
  constexpr double nothing = std::numeric_limits<double>::max(), nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_LT(bound(800, 1e-3), 1.0);
  for (const double bad : {0.0, -1.0, nan}) {
    EXPECT_EQ(bound(bad, 1e-3), nothing);
    EXPECT_EQ(bound(800, bad), nothing);
  }
}

}  // namespace extremes_test
}  // namespace palpa
