// Statements of docs/theory.md on one balance, on random problems; sequences of balances: passivity_test.cpp.
#include "tests/solver/theory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace palpa {
namespace theory_test {

using namespace test::theory;
using test::Problem;
using test::Random;
using test::random_problem;

TEST(Energy, IsStronglyConvex) {
  Random random(101);
  for (int i = 0; i < 20000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(6), i % 2 == 1);
    const Vec3 x = problem.start_m + random.in_cube(0.006), y = problem.start_m + random.in_cube(0.006);
    const double share = random.uniform(0, 1);
    const double chord = share * energy(problem, x) + (1 - share) * energy(problem, y);
    const double bulge = 0.5 * problem.stiffness_n_per_m * share * (1 - share) * norm_squared(x - y);
    EXPECT_LE(energy(problem, share * x + (1 - share) * y), chord - bulge + 1e-15);
  }
}

// The printed forces are zero at r = 0 and s beside it: their sum with the spring's has no zero at a resting proxy.
TEST(Energy, PrintedForcesHaveNoZeroWhereAProxyRests) {
  constexpr double k = 800, s = 3, depth_m = 0.002;
  const Problem problem{{{PrimitiveKind::plane, {}, {}, {0, 0, 1}, s}}, {}, {0, 0, -depth_m}, k, tick_s};
  const auto printed_left = [&](double z_m) { return (z_m < 0.0 ? s : 0.0) - k * (z_m + depth_m); };
  for (int i = -4000; i <= 4000; ++i) EXPECT_GE(std::abs(printed_left(1e-6 * i)), 1.3999);
  const Solved solved = solve(problem);
  EXPECT_EQ(solved.balance.position_m, Vec3{});  // with any force from 0 to s at r = 0 there is a zero
  EXPECT_NEAR(solved.forces_n[0].z, k * depth_m, 1e-12);
}

TEST(Split, OfRedundantPrimitivesIsNotUniqueButTheirSumIs) {
  const Primitive weak{PrimitiveKind::point, {0, 0}, {}, {}, 1.0}, strong{PrimitiveKind::point, {0, 1}, {}, {}, 2.0};
  const Problem problem{{weak, strong}, {}, {-0.003, 0, 0}, 500, tick_s};
  for (const double share_n : {0.0, 0.3, 0.5, 1.0}) {  // of the strong one: from 0.5 N to 1.5 N
    const Vec3 forces[] = {{share_n, 0, 0}, {1.5 - share_n, 0, 0}};
    EXPECT_LE(error_bound_m(problem.primitives, forces, {}, problem.probe_m, 500, tick_s), 1e-12) << share_n;
  }
  const Vec3 not_enough[] = {{1.0, 0, 0}, {0.4, 0, 0}};
  EXPECT_GE(error_bound_m(problem.primitives, not_enough, {}, problem.probe_m, 500, tick_s), 1e-4);
  EXPECT_NEAR(distance(total(solve(problem).forces_n), {1.5, 0, 0}), 0.0, 1e-9);
}

TEST(Dual, EnergyMinusDualIsTheGapAndTheForceLeftOver) {
  Random random(102);
  for (int i = 0; i < 20000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(6), i % 2 == 1);
    const std::vector<Vec3> forces = some_forces(random, problem);
    const Vec3 x = problem.start_m + random.in_cube(0.006);
    const double rho = force_left(problem, forces, x);
    const double apart = energy(problem, x) - dual(problem, forces);
    EXPECT_NEAR(apart, gap(problem, forces, x) + 0.5 * rho * rho / problem.stiffness_n_per_m, 1e-14 * (1.0 + apart));
    EXPECT_GE(apart, 0.0);  // weak duality
    for (std::size_t j = 0; j < forces.size(); ++j) {
      if (problem.primitives[j].kind == PrimitiveKind::directed) continue;
      Problem one = problem;
      one.primitives = {problem.primitives[j]};
      EXPECT_GE(gap(one, {forces[j]}, x), -1e-15) << "the gap is a sum of terms none of which is negative";
    }
  }
}

// With common point o: Z = C + Proj_W(−C). W is described by its support function max u·e in every direction e.
TEST(Dual, AProxyRestsIffTheSumOfForceSetsHoldsTheDemand) {
  Random random(103);
  int resting = 0;
  for (int i = 0; i < 5000; ++i) {
    Problem problem = problem_through(random, random.in_cube(0.05), 1 + random.below(5), false);
    problem.probe_m = problem.start_m + random.in_cube(0.01);
    const double k = problem.stiffness_n_per_m;
    const auto reach = [&](const Vec3& e) {
      double sum = 0.0;
      for (const Primitive& p : problem.primitives) {
        const double along = p.kind == PrimitiveKind::point   ? 1.0
                             : p.kind == PrimitiveKind::plane ? std::max(0.0, dot(p.direction, e))
                                                              : norm(e - dot(p.direction, e) * p.direction);
        sum += p.strength_n * along;
      }
      return sum;
    };
    const Balance balance = solve(problem).balance;
    const Vec3 demand = -k * (problem.probe_m - problem.start_m), Z = k * (balance.position_m - problem.start_m);
    const double slack = k * balance.error_bound_m + 1e-12;
    if (norm(Z) <= slack) {
      ++resting;
      for (int j = 0; j < 200; ++j) {
        const Vec3 e = random.direction();
        EXPECT_LE(dot(demand, e), reach(e) + slack);
      }
    } else {  // Z is the missing force, across the face of W that is nearest to the demand
      const Vec3 e = normalized(-Z);
      const double turned = slack / norm(Z) * (norm(demand) + reach(e) + norm(Z));
      EXPECT_NEAR(dot(demand, e) - reach(e), norm(Z), 4.0 * (slack + turned));
    }
  }
  EXPECT_GT(resting, 200);
  EXPECT_LT(resting, 4800);
}

// One sweep: each force in turn becomes optimal, all others held.
void sweep(const Problem& problem, std::vector<Vec3>& forces) {
  const double k = problem.stiffness_n_per_m;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    const Vec3 without_m = problem.probe_m + (total(forces) - forces[i]) / k;
    const Vec3 d = p.position_m - without_m;
    const Vec3 wanted = k * (p.kind == PrimitiveKind::plane  ? std::max(0.0, dot(p.direction, d)) * p.direction
                             : p.kind == PrimitiveKind::line ? d - dot(p.direction, d) * p.direction
                                                             : d);
    const double C = drag_stiffness(p, problem), excess = norm(wanted) - p.strength_n;
    forces[i] = shortened(wanted, excess > 0.0 ? p.strength_n + C * excess / (k + C) : norm(wanted));
  }
}

TEST(Sweep, NeverLowersTheDualAndBoundsTheProxyByIt) {
  Random random(104);
  for (int i = 0; i < 500; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(6), i % 2 == 1);
    const Solved solved = solve(problem);
    const double k = problem.stiffness_n_per_m;
    const double least = energy(problem, solved.balance.position_m) + energy_slack(problem, solved.balance);
    std::vector<Vec3> forces = some_forces(random, problem);
    double last = dual(problem, forces);
    for (int j = 0; j < 20; ++j) {
      sweep(problem, forces);
      const double now = dual(problem, forces);
      EXPECT_GE(now, last - 1e-15);
      const double off = distance(problem.probe_m + total(forces) / k, solved.balance.position_m);
      const double off_at_least = std::max(0.0, off - solved.balance.error_bound_m);
      EXPECT_LE(0.5 * k * off_at_least * off_at_least, least - now + 1e-15);
      last = now;
    }
  }
}

TEST(Sweep, OverTwoPlanesContractsByTheSquaredCosine) {
  Random random(105);
  for (const double angle_deg : {5.0, 10.0, 20.0, 45.0, 60.0, 80.0}) {
    const double half = 0.5 * angle_deg * std::numbers::pi / 180.0, cosine = std::cos(2.0 * half);
    const Mat3 frame = random.rotation();
    const Vec3 q1 = normalized(std::cos(half) * frame.row[0] + std::sin(half) * frame.row[1]);
    const Vec3 q2 = normalized(std::cos(half) * frame.row[0] - std::sin(half) * frame.row[1]);
    const Problem problem{{{PrimitiveKind::plane, {0, 0}, {}, q1, 1e3}, {PrimitiveKind::plane, {0, 1}, {}, q2, 1e3}},
                          {},
                          -0.004 * normalized(frame.row[0]),  // into both: the proxy stays in the edge, at zero
                          500,
                          tick_s};
    std::vector<Vec3> forces(2);
    sweep(problem, forces);
    double off = norm(problem.probe_m + total(forces) / 500);
    for (int j = 0; j < 10 && off > 1e-9; ++j) {
      sweep(problem, forces);
      const double now = norm(problem.probe_m + total(forces) / 500);
      EXPECT_NEAR(now / off, cosine * cosine, 1e-5) << angle_deg << " degrees, sweep " << j;
      off = now;
    }
    EXPECT_LE(norm(solve(problem).balance.position_m), 1e-9) << angle_deg;
  }
}

// One pass: the v of largest k D(v) − |v − u|²/(2τ), by sweeps of v to convergence. In newtons about the start.
std::vector<Vec3> multiplied(const Problem& problem, const std::vector<Vec3>& u, double tau) {
  const double k = problem.stiffness_n_per_m, own = 1.0 + 1.0 / tau;
  std::vector<Vec3> v = u;
  double moved = 1.0;
  for (int i = 0; i < 20000 && moved > 1e-15; ++i) {
    moved = 0.0;
    for (std::size_t j = 0; j < v.size(); ++j) {
      const Primitive& p = problem.primitives[j];
      if (p.kind == PrimitiveKind::directed) continue;
      const Vec3 Z_without = k * (problem.probe_m - problem.start_m) + total(v) - v[j];
      const Vec3 W = (1.0 / own) * (k * (p.position_m - problem.start_m) - Z_without + (1.0 / tau) * u[j]);
      const Vec3 asked = p.kind == PrimitiveKind::plane  ? std::max(0.0, dot(p.direction, W)) * p.direction
                         : p.kind == PrimitiveKind::line ? W - dot(p.direction, W) * p.direction
                                                         : W;
      const double gamma = drag_stiffness(p, problem) / k, excess = norm(asked) - p.strength_n;
      const Vec3 best =
          shortened(asked, excess > 0.0 ? p.strength_n + own * gamma * excess / (1.0 + own * gamma) : norm(asked));
      moved = std::max(moved, norm(best - v[j]));
      v[j] = best;
    }
  }
  return v;
}

TEST(Multipliers, RaiseTheDualAsTheSumOfPenaltiesSays) {
  Random random(115);
  for (int i = 0; i < 200; ++i) {
    const Problem problem = random_problem(random, 2 + random.below(4), i % 2 == 1);
    const double k = problem.stiffness_n_per_m;
    const std::vector<Vec3> best = solve(problem).forces_n;
    std::vector<Vec3> forces = some_forces(random, problem);
    double off_n2 = 0.0, penalties = 0.0;
    for (std::size_t j = 0; j < forces.size(); ++j) off_n2 += norm_squared(best[j] - forces[j]);
    double last = dual(problem, forces);
    for (const double tau : {0.3, 1.0, 3.0, 10.0, 30.0}) {
      forces = multiplied(problem, forces, tau);
      penalties += tau;
      const double now = dual(problem, forces);
      EXPECT_GE(now, last - 1e-15);
      EXPECT_LE(k * (dual(problem, best) - now), 0.5 * off_n2 / penalties + 1e-11);
      last = now;
    }
  }
}

TEST(Certificate, HoldsForAnyPlaceAndAnyForces) {
  Random random(106);
  for (int i = 0; i < 20000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(6), i % 2 == 1);
    const Solved solved = solve(problem);
    const double k = problem.stiffness_n_per_m;
    // From far to near, forces between random ones and those of the balance.
    const double share = std::pow(10.0, random.uniform(-7, 0));
    const Vec3 x = solved.balance.position_m + share * random.in_cube(0.006);
    std::vector<Vec3> forces = some_forces(random, problem);
    for (std::size_t j = 0; j < forces.size(); ++j) forces[j] = share * forces[j] + (1 - share) * solved.forces_n[j];
    const double off = distance(x, solved.balance.position_m) - solved.balance.error_bound_m;
    EXPECT_GE(error_bound_m(problem.primitives, forces, x, problem.probe_m, k, problem.time_step_s), off);
    if (off <= 0.0) continue;
    const double rho = force_left(problem, forces, x), eps = gap(problem, forces, x);
    EXPECT_LE(k * off * off, rho * off + eps + 1e-13);
    EXPECT_LE(0.5 * k * off * off, eps + 0.5 * rho * rho / k + 1e-13);  // the plainer one, never tighter
    EXPECT_LE(std::pow(rho + std::sqrt(rho * rho + 4 * k * std::max(0.0, eps)), 2) / 4,
              (rho * rho + 2 * k * std::max(0.0, eps)) * (1 + 1e-12));
  }
}

TEST(Certificate, IsTheFormulaAsItIsWritten) {
  Random random(114);
  for (int i = 0; i < 20000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(6), i % 2 == 1);
    const double k = problem.stiffness_n_per_m;
    const std::vector<Vec3> forces = some_forces(random, problem);
    const Vec3 x = problem.start_m + random.in_cube(0.006);
    const double rho = force_left(problem, forces, x), eps = gap(problem, forces, x);
    const double formula_m = (rho + std::sqrt(rho * rho + 4 * k * std::max(0.0, eps))) / (2 * k);
    const double bound_m = error_bound_m(problem.primitives, forces, x, problem.probe_m, k, problem.time_step_s);
    EXPECT_GE(bound_m, formula_m * (1 - 1e-12));
    EXPECT_LE(bound_m, formula_m * (1 + 1e-9) + 1e-9);
  }
}

TEST(Certificate, IsAttained) {
  // A plane at zero that can just hold; the probe itself as the answer, and no force: off by s/k, the bound is s/k.
  constexpr double k = 400, s = 2;
  const Primitive plane{PrimitiveKind::plane, {}, {}, {0, 0, 1}, s};
  const Vec3 probe{0, 0, -s / k};
  const Vec3 none[] = {{}};
  EXPECT_EQ(norm(solve({{plane}, {}, probe, k, tick_s}).balance.position_m), 0.0);
  EXPECT_NEAR(error_bound_m({&plane, 1}, none, probe, probe, k, tick_s), s / k, 1e-15);
  // No primitives: the spring's force alone is residual.
  EXPECT_NEAR(error_bound_m({}, {}, {0, 0, 0.003}, {}, k, tick_s), 0.003, 1e-15);
}

// 1.4 N of residual force at the balance itself, on the plane's lower side, and hardly more 60 µm away from it.
TEST(Certificate, SeesWhatTheForceLeftOverCannot) {
  constexpr double k = 800, s = 3, off_m = 6e-5;
  const Primitive plane{PrimitiveKind::plane, {}, {}, {0, 0, 1}, s};
  const Problem problem{{plane}, {}, {0.005, 0, -0.002}, k, tick_s};
  const Solved solved = solve(problem);
  EXPECT_LE(distance(solved.balance.position_m, {0.005, 0, 0}), 1e-9);
  const auto printed_left = [&](const Vec3& x) { return norm(s * normalized(residual(plane, x)) - k * (x - problem.probe_m)); };
  const Vec3 below{0, 0, -1e-12}, aside{off_m, 0, 0};
  const double at = printed_left(solved.balance.position_m + below),
               beside = printed_left(solved.balance.position_m + aside + below);
  EXPECT_NEAR(at, 1.4, 1e-6);
  EXPECT_NEAR(beside, at, 1e-3);
  EXPECT_GE(printed_left(solved.balance.position_m), at) << "on the plane itself more is left over than below";
  const auto bound_m = [&](const Vec3& x) {
    return error_bound_m(problem.primitives, solved.forces_n, x, problem.probe_m, k, tick_s);
  };
  EXPECT_LE(bound_m(solved.balance.position_m), 1e-9);
  EXPECT_GE(bound_m(solved.balance.position_m + aside), off_m);
}

// Points, drags included, come last: x = a + f (y − a), y the balance of the drag-free rest.
TEST(ClosedForm, PointsComposeWithADragFreeRestAtTheSamePlace) {
  Random random(107);
  for (int i = 0; i < 5000; ++i) {
    Problem rest = problem_through(random, random.in_cube(0.05), 1 + random.below(4), false);
    Problem both = rest;
    const double k = rest.stiffness_n_per_m;
    double s = 0.0, C = 0.0;
    for (int j = 0; j < 1 + random.below(3); ++j) {
      Primitive point{PrimitiveKind::point, {1, static_cast<std::uint16_t>(100 + j)}, rest.start_m, {}, random.uniform(0, 1)};
      if (i % 2 == 1) point.drag_ns_per_m = random.uniform(0, 1);
      both.primitives.push_back(point);
      s += point.strength_n;
      C += drag_stiffness(point, both);
    }
    const Balance alone = solve(rest).balance, together = solve(both).balance;
    const Vec3 y = alone.position_m - rest.start_m;
    const double pulled = k * norm(y);
    const Vec3 x = rest.start_m + (pulled > s ? (pulled - s) / (k + C) / norm(y) * y : Vec3{});
    EXPECT_LE(distance(together.position_m, x), alone.error_bound_m + together.error_bound_m + 1e-16);
  }
}

}  // namespace theory_test
}  // namespace palpa
