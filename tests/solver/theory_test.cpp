// The statements of docs/theory.md, each checked on random problems.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "palpa/solver/solver.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace theory_test {

using test::fill;
using test::Problem;
using test::Random;
using test::random_problem;

constexpr double tick_s = 1e-3;

struct Solved {
  Balance balance;
  std::vector<Vec3> forces_n;
};

Solved solve(const Problem& problem) {
  const std::size_t capacity = std::max<std::size_t>(1, problem.primitives.size());
  PrimitiveSet set(capacity);
  fill(set, problem);
  EXPECT_EQ(set.dropped(), 0);
  Solver solver(capacity);
  const Balance balance = solver.solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
  return {balance, {solver.forces_n().begin(), solver.forces_n().end()}};
}

Vec3 directed_sum(const Problem& problem) {
  Vec3 sum;
  for (const Primitive& p : problem.primitives) {
    if (p.kind == PrimitiveKind::directed) sum += p.strength_n * p.direction;
  }
  return sum;
}

double drag_stiffness(const Primitive& p, const Problem& problem) { return p.drag_ns_per_m / problem.time_step_s; }

// φ(r) = s|r| + C/2 |r|²
double dissipation(const Primitive& p, const Problem& problem, const Vec3& x) {
  const double r = norm(residual(p, x));
  return p.strength_n * r + 0.5 * drag_stiffness(p, problem) * r * r;
}

double dissipation(const Problem& problem, const Vec3& x) {
  double sum = 0.0;
  for (const Primitive& p : problem.primitives) sum += dissipation(p, problem, x);
  return sum;
}

double spring(const Problem& problem, const Vec3& x) {
  return 0.5 * problem.stiffness_n_per_m * norm_squared(x - problem.probe_m);
}

// E(x), with the directed forces' potential counted from the start.
double energy(const Problem& problem, const Vec3& x) {
  return spring(problem, x) - dot(directed_sum(problem), x - problem.start_m) + dissipation(problem, x);
}

// φ*(u) of a force that the primitive can exert.
double conjugate(const Primitive& p, const Problem& problem, const Vec3& u) {
  const double excess = std::max(0.0, norm(u) - p.strength_n);
  return p.drag_ns_per_m > 0.0 ? 0.5 * excess * excess / drag_stiffness(p, problem) : 0.0;
}

// Any force that the primitive can exert: of its span, and beyond its strength only with a drag.
Vec3 some_force(Random& random, const Primitive& p) {
  const double length = random.uniform(0.0, p.drag_ns_per_m > 0.0 ? 2.0 * p.strength_n + 0.1 : p.strength_n);
  if (p.kind == PrimitiveKind::plane) return length * p.direction;
  const Vec3 any = random.direction();
  return length * (p.kind == PrimitiveKind::line ? normalized(any - dot(p.direction, any) * p.direction) : any);
}

std::vector<Vec3> some_forces(Random& random, const Problem& problem) {
  std::vector<Vec3> forces;
  for (const Primitive& p : problem.primitives)
    forces.push_back(p.kind == PrimitiveKind::directed ? p.strength_n * p.direction : some_force(random, p));
  return forces;
}

Vec3 total(const std::vector<Vec3>& forces) {
  Vec3 sum;
  for (const Vec3& u : forces) sum += u;
  return sum;
}

// The dual function: the least of k/2 |x − p|² − d·x + Σ u·R(x) − φ*(u) over x.
double dual(const Problem& problem, const std::vector<Vec3>& forces) {
  const Vec3 F = total(forces);
  double value = -0.5 * norm_squared(F) / problem.stiffness_n_per_m - dot(F, problem.probe_m - problem.start_m);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    if (p.kind != PrimitiveKind::directed)
      value += dot(forces[i], p.position_m - problem.start_m) - conjugate(p, problem, forces[i]);
  }
  return value;
}

// ε = Σ φ(r) + φ*(u) − u·R and ρ = |k (x − p) − Σ forces|, as they are written.
double gap(const Problem& problem, const std::vector<Vec3>& forces, const Vec3& x) {
  double sum = 0.0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    sum += dissipation(p, problem, x) + conjugate(p, problem, forces[i]) - dot(forces[i], p.position_m - x);
  }
  return sum;
}

double force_left(const Problem& problem, const std::vector<Vec3>& forces, const Vec3& x) {
  return norm(problem.stiffness_n_per_m * (x - problem.probe_m) - total(forces));
}

// How much E can change between the computed balance and the exact one.
double energy_slack(const Problem& problem, const Balance& balance) {
  double slope = problem.stiffness_n_per_m * (distance(balance.position_m, problem.probe_m) + balance.error_bound_m);
  for (const Primitive& p : problem.primitives)
    slope += p.strength_n + drag_stiffness(p, problem) * (norm(residual(p, balance.position_m)) + balance.error_bound_m);
  return slope * balance.error_bound_m + 1e-16;
}

// Every point, line and plane goes through `at`; no directed forces.
Problem problem_through(Random& random, const Vec3& at, int n, bool drags) {
  Problem problem = random_problem(random, n, false);
  problem.start_m = at;
  for (Primitive& p : problem.primitives) {
    if (p.kind == PrimitiveKind::directed) p.kind = PrimitiveKind::point;
    p.position_m = at;
    if (drags && random.below(2) == 0) p.drag_ns_per_m = random.uniform(0, 20);
  }
  return problem;
}

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

// The printed forces are zero at r = 0 and s beside it: their sum with the spring's has no zero where a proxy rests.
TEST(Energy, PrintedForcesHaveNoZeroWhereAProxyRests) {
  constexpr double k = 800, s = 3, depth_m = 0.002;
  const Problem problem{{{PrimitiveKind::plane, {}, {}, {0, 0, 1}, s}}, {}, {0, 0, -depth_m}, k, tick_s};
  const auto printed_left = [&](double z_m) { return (z_m < 0.0 ? s : 0.0) - k * (z_m + depth_m); };
  for (int i = -4000; i <= 4000; ++i) EXPECT_GE(std::abs(printed_left(1e-6 * i)), 1.3999);
  const Solved solved = solve(problem);
  EXPECT_EQ(solved.balance.position_m, Vec3{});  // with any force from 0 to s at r = 0 there is one
  EXPECT_NEAR(solved.forces_n[0].z, k * depth_m, 1e-12);
}

TEST(Split, OfRedundantPrimitivesIsNotUniqueButTheirSumIs) {
  const Primitive weak{PrimitiveKind::point, {0, 0}, {}, {}, 1.0}, strong{PrimitiveKind::point, {0, 1}, {}, {}, 2.0};
  const Problem problem{{weak, strong}, {}, {-0.003, 0, 0}, 500, tick_s};  // 1.5 N are asked for
  for (const double share_n : {0.0, 0.3, 0.5, 1.0}) {                      // of the strong one: from 0.5 N to 1.5 N
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

// With common place o: Z = C + Proj_W(−C). W is known by its reach Σ max u·e in every direction e.
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
    } else {  // Z is what is missing, across the face of W that is nearest to the demand
      const Vec3 e = normalized(-Z);
      const double turned = slack / norm(Z) * (norm(demand) + reach(e) + norm(Z));
      EXPECT_NEAR(dot(demand, e) - reach(e), norm(Z), 4.0 * (slack + turned));
    }
  }
  EXPECT_GT(resting, 200);
  EXPECT_LT(resting, 4800);
}

// One sweep: each force in turn is the best one, all others held.
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

// One pass: the v of largest k D(v) − |v − u|²/(2τ), by sweeps of v until they stand still. In newtons about the start.
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
    // From far off to close by, the forces between any and those of the balance.
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

// Sums of products and all that is added for rounding come to the formula of the theorem.
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
  // A plane at zero that can just hold; the probe itself as the answer, and no force: off by s/k, the bound says s/k.
  constexpr double k = 400, s = 2;
  const Primitive plane{PrimitiveKind::plane, {}, {}, {0, 0, 1}, s};
  const Vec3 probe{0, 0, -s / k};
  const Vec3 none[] = {{}};
  EXPECT_EQ(norm(solve({{plane}, {}, probe, k, tick_s}).balance.position_m), 0.0);
  EXPECT_NEAR(error_bound_m({&plane, 1}, none, probe, probe, k, tick_s), s / k, 1e-15);
  // No primitives: nothing but the spring's force is left over.
  EXPECT_NEAR(error_bound_m({}, {}, {0, 0, 0.003}, {}, k, tick_s), 0.003, 1e-15);
}

// 1.4 N are left over at the balance itself, on the plane's lower side, and hardly more 60 µm away from it.
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

// Points, drags and all, come last: x = a + f (y − a), y the balance of the rest, which is drag-free.
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
    EXPECT_LE(norm_squared(df), -k * dot(df, dp) + slack_n * (k * norm(dp) + 2.0 * norm(df) + slack_n));  // firmly
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

// What non-expansiveness does not say: as soon as primitives change, a still hand's proxy may move.
TEST(Balance, OfAStillHandMovesWhereItsPrimitivesDo) {
  const Primitive plane{PrimitiveKind::plane, {}, {}, {0, 0, 1}, 2.0};
  Problem problem{{plane}, {}, {0, 0, -0.002}, 500, tick_s};
  const Vec3 held = solve(problem).balance.position_m;
  problem.start_m = held;
  problem.primitives[0].direction = normalized({1, 0, 1});
  problem.primitives[0].strength_n = 0.1;
  const Vec3 let_go = solve(problem).balance.position_m;
  EXPECT_NEAR(distance(held, let_go), 0.002, 0.1 / 500 + 1e-9);
}

// The map x ← p + d(x)/k of a hand held still: at rest where |∂d/∂x| < k, to and fro where it is more.
TEST(DirectedForce, ComesToRestOnlyWhereItsSlopeIsBelowTheStiffness) {
  constexpr double k = 500;
  for (const double share : {0.5, 0.9, 1.1, 2.0}) {  // of k
    double x = 1e-4, last_step = 0.0, step = 0.0;
    for (int i = 0; i < 30; ++i) {
      const double force_n = -share * k * x;  // towards zero, read at the proxy
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
      EXPECT_GE(work_j, released_j - slack_j);  // nor does it ever take more than it stores
      now = next;
    }
  }
}

// A round trip: a device that damps with b = kT/2 takes out at least what fixed primitives give.
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
      damped_j += 0.5 * k * norm_squared(dp);  // (kT/2) ∫|v|² dt, the hand's speed even over a tick: the least there is
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

// … and a primitive elsewhere brings in at most its strength times its distance; a directed force d·Δx.
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

// A directed force that turns with the place drives a hand round and round, at any rate.
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

}  // namespace theory_test
}  // namespace palpa
