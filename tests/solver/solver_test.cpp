// Laws of the balance (solver.h, law.h) for any numbers.
#include "palpa/solver/solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

#include "palpa/solver/damper.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace solver_test {

using test::fill;
using test::Problem;
using test::Random;
using test::random_problem;

Balance solve(const Problem& problem) {
  PrimitiveSet set(std::max<std::size_t>(1, problem.primitives.size()));
  fill(set, problem);
  EXPECT_EQ(set.dropped(), 0);
  return solve_once(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
}

Primitive primitive(PrimitiveKind kind, const Vec3& position, const Vec3& direction, double strength, double drag = 0.0) {
  return {kind, {}, position, direction, strength, drag};
}

// Energy whose minimiser the balance is.
double energy(const Problem& problem, const Vec3& x) {
  double e = 0.5 * problem.stiffness_n_per_m * norm_squared(x - problem.probe_m);
  for (const Primitive& p : problem.primitives) {
    if (p.kind == PrimitiveKind::directed) {
      e -= p.strength_n * dot(p.direction, x - problem.start_m);
      continue;
    }
    const double r = norm(residual(p, x));
    e += p.strength_n * r + 0.5 * p.drag_ns_per_m / problem.time_step_s * r * r;
  }
  return e;
}

TEST(Balance, WithoutPrimitivesIsTheProbeItself) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Problem problem = random_problem(random, 0, false);
    const Balance balance = solve(problem);
    EXPECT_EQ(balance.position_m, problem.probe_m);
    EXPECT_EQ(balance.error_bound_m, 0.0);
  }
}

// Paper, Fig. 3 a–c and d; likewise for point and line.
TEST(Balance, HoldsUntilStiffnessTimesDepthReachesTheStrengthThenTrailsByStrengthOverStiffness) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 q = random.direction();
    const Vec3 across = normalized(cross(q, random.direction()));
    const Vec3 a = random.in_cube(0.05);
    const double k = random.uniform(100, 3000);
    const double s = random.uniform(0.1, 5);
    for (const double share : {0.0, 0.3, 0.999, 1.001, 2.0, 7.0}) {
      const double depth = share * s / k;
      struct Case {
        PrimitiveKind kind;
        Vec3 away;
      };
      for (const Case c :
           {Case{PrimitiveKind::plane, -q}, Case{PrimitiveKind::point, across}, Case{PrimitiveKind::line, across}}) {
        Problem problem{{primitive(c.kind, a, q, s)}, a, a + depth * c.away, k, 1e-3};
        const Balance balance = solve(problem);
        const double apart = distance(balance.position_m, problem.probe_m);
        EXPECT_NEAR(apart, std::min(depth, s / k), 1e-16 + 4e-16 * norm(a)) << name_of(c.kind) << " at share " << share;
        if (share < 1.0) {
          EXPECT_NEAR(distance(balance.position_m, a), 0.0, 1e-16);
        }
        EXPECT_EQ(balance.status, BalanceStatus::exact);
        EXPECT_LE(balance.error_bound_m, 1e-9);
      }
    }
  }
}

TEST(Balance, LeavesAPlaneFreelyAndALineAlongItsDirection) {
  const Vec3 a{0.01, 0.02, 0.03};
  const Vec3 q{0, 0, 1};
  EXPECT_EQ(solve({{primitive(PrimitiveKind::plane, a, q, 3)}, a, a + Vec3{0, 0, 0.002}, 800, 1e-3}).position_m,
            (a + Vec3{0, 0, 0.002}));
  const Balance along = solve({{primitive(PrimitiveKind::line, a, q, 3)}, a, a + Vec3{0.001, 0, 0.002}, 800, 1e-3});
  EXPECT_NEAR(distance(along.position_m, a + Vec3{0, 0, 0.002}), 0.0, 1e-17);
}

// Paper, Fig. 2: plane and point in one balance; the three forces close a triangle.
TEST(Balance, OfPlaneAndPointClosesTheForceTriangle) {
  const double k = 500;
  const Vec3 plane_at{0, 0, 0};
  const Vec3 point_at{0.004, 0, -0.001};
  Problem problem{
      {primitive(PrimitiveKind::plane, plane_at, {0, 0, 1}, 2.0), primitive(PrimitiveKind::point, point_at, {}, 0.7)},
      {},
      {-0.003, 0.001, -0.003},
      k,
      1e-3};
  problem.primitives[1].id.slot = 1;
  PrimitiveSet set(4);
  fill(set, problem);
  Solver solver(4);
  const Balance balance = solver.solve(set, problem.start_m, problem.probe_m, k, 1e-3);
  const Vec3 feedback = -k * (balance.position_m - problem.probe_m);
  const Vec3 left = feedback + solver.forces_n()[0] + solver.forces_n()[1];
  EXPECT_LT(norm(left), 1e-12);
  EXPECT_NEAR(norm(solver.forces_n()[1]), 0.7, 1e-12);  // the point slips: full strength …
  const Vec3 towards = normalized(point_at - balance.position_m);
  EXPECT_NEAR(distance(towards, normalized(solver.forces_n()[1])), 0.0, 1e-9);  // … straight at the point
  EXPECT_NEAR(balance.position_m.z, 0.0, 1e-15);                                // the plane holds
}

TEST(Balance, IsTheMinimiserOfTheEnergy) {
  Random random(3);
  for (int i = 0; i < 3000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(6), i % 2 == 1);
    const Balance balance = solve(problem);
    const double at = energy(problem, balance.position_m);
    for (int j = 0; j < 20; ++j) {
      const Vec3 d = random.in_cube(1e-4);
      // Strong convexity: E(x* + d) ≥ E(x*) + k/2 |d|²; the bound allows for x being not quite x*.
      const double slack = 40.0 * (balance.error_bound_m + 1e-15);
      EXPECT_GE(energy(problem, balance.position_m + d), at + 0.5 * problem.stiffness_n_per_m * norm_squared(d) - slack);
    }
  }
}

TEST(Balance, SatisfiesTheInclusionPrimitiveByPrimitive) {
  Random random(4);
  int capped = 0;
  for (int i = 0; i < 3000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(5), i % 2 == 1);
    PrimitiveSet set(8);
    fill(set, problem);
    Solver solver(8);
    const Balance balance = solver.solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
    if (balance.status != BalanceStatus::exact) {
      ++capped;
      continue;
    }
    Vec3 sum = -problem.stiffness_n_per_m * (balance.position_m - problem.probe_m);
    for (std::size_t j = 0; j < set.size(); ++j) {
      const Primitive& p = set[j];
      const Vec3 u = solver.forces_n()[j];
      sum += u;
      const double s = p.strength_n;
      if (p.kind == PrimitiveKind::directed) {
        EXPECT_EQ(u, s * p.direction);
        continue;
      }
      const Vec3 r = residual(p, balance.position_m);
      const double wanted = s + p.drag_ns_per_m / problem.time_step_s * norm(r);
      EXPECT_LE(norm(u), wanted + 1e-5);
      if (norm(r) > 1e-6) {
        EXPECT_NEAR(norm(u), wanted, 1e-5 * (1 + wanted));
        EXPECT_GE(dot(u, r), (1 - 1e-5) * norm(u) * norm(r));
      }
      if (p.kind == PrimitiveKind::line) {
        EXPECT_NEAR(dot(u, p.direction), 0.0, 1e-14);
      }
      if (p.kind == PrimitiveKind::plane) {
        EXPECT_NEAR(norm(cross(u, p.direction)), 0.0, 1e-14);
      }
    }
    EXPECT_LT(norm(sum), 1e-9);
  }
  EXPECT_LT(capped, 15) << "of 3000";
}

TEST(Balance, DoesNotDependOnOrderRotationOrScale) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const Problem problem = random_problem(random, 2 + random.below(4), i % 2 == 1);
    const Balance balance = solve(problem);
    const double tolerance = 2.0 * balance.error_bound_m + 1e-12;

    Problem permuted = problem;
    for (std::size_t j = permuted.primitives.size(); j-- > 1;)
      std::swap(permuted.primitives[j], permuted.primitives[static_cast<std::size_t>(random.below(static_cast<int>(j) + 1))]);
    const Balance other = solve(permuted);
    EXPECT_LE(distance(other.position_m, balance.position_m), tolerance + other.error_bound_m);

    const Mat3 rotation = random.rotation();
    const Vec3 shift = random.in_cube(0.02);
    const auto moved = [&](const Vec3& x) { return rotation * x + shift; };
    Problem turned = problem;
    turned.start_m = moved(problem.start_m);
    turned.probe_m = moved(problem.probe_m);
    for (Primitive& p : turned.primitives) {
      p.position_m = moved(p.position_m);
      p.direction = normalized(rotation * p.direction);
      // A drag must be at the start to the last bits, also after the turn.
      if (p.drag_ns_per_m > 0.0) p.position_m = turned.start_m;
    }
    const Balance turned_balance = solve(turned);
    EXPECT_LE(distance(turned_balance.position_m, moved(balance.position_m)), tolerance + turned_balance.error_bound_m);

    Problem scaled = problem;  // (k, s, c) → λ (k, s, c) moves nothing
    scaled.stiffness_n_per_m *= 1.75;
    for (Primitive& p : scaled.primitives) p.strength_n *= 1.75, p.drag_ns_per_m *= 1.75;
    const Balance scaled_balance = solve(scaled);
    EXPECT_LE(distance(scaled_balance.position_m, balance.position_m), tolerance + scaled_balance.error_bound_m);
  }
}

TEST(Balance, IsFirmlyNonExpansiveInTheProbe) {
  Random random(6);
  for (int i = 0; i < 5000; ++i) {
    Problem problem = random_problem(random, 1 + random.below(5), false);
    const Balance first = solve(problem);
    const Vec3 p = problem.probe_m;
    problem.probe_m += random.in_cube(0.002);
    const Balance second = solve(problem);
    const Vec3 dx = second.position_m - first.position_m;
    EXPECT_LE(norm_squared(dx), dot(dx, problem.probe_m - p) + 0.01 * (first.error_bound_m + second.error_bound_m) + 1e-17);
  }
}

// The update of 2003: each axis of an orthogonal frame moves the proxy on its own.
TEST(Balance, OfOrthogonalSetsIsTheConstraintMethodToRounding) {
  Random random(7);
  for (int i = 0; i < 3000; ++i) {
    const Mat3 frame = random.rotation();
    const Vec3 e1 = normalized(frame.row[0]);
    const Vec3 x = random.in_cube(0.05);
    const Vec3 d = random.in_cube(0.004);
    const double k = random.uniform(200, 2000);
    const double t_surface = random.uniform(0, 4);
    const double t_friction = random.uniform(0, 2);
    Problem problem{{primitive(PrimitiveKind::plane, x, e1, t_surface), primitive(PrimitiveKind::line, x, e1, t_friction)},
                    x,
                    x + d,
                    k,
                    1e-3};
    problem.primitives[1].id.slot = 1;
    const double along = dot(d, e1);
    const double move_1 = along >= 0 ? along : -std::max(0.0, -along - t_surface / k);
    const Vec3 tangential = d - along * e1;
    const double length = norm(tangential);
    const Vec3 move_t = length > 0 ? std::max(0.0, length - t_friction / k) / length * tangential : Vec3{};
    const Vec3 expected = x + move_1 * e1 + move_t;
    EXPECT_NEAR(distance(solve(problem).position_m, expected), 0.0, 1e-16);

    // Three mutually orthogonal unilateral axes.
    Problem corner{{}, x, x + d, k, 1e-3};
    Vec3 moved = x;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 e = normalized(frame.row[axis]);
      const double s = random.uniform(0, 3);
      corner.primitives.push_back(primitive(PrimitiveKind::plane, x, e, s));
      corner.primitives.back().id.slot = static_cast<std::uint16_t>(axis);
      const double D = dot(d, e);
      moved += (D >= 0 ? D : -std::max(0.0, -D - s / k)) * e;
    }
    EXPECT_NEAR(distance(solve(corner).position_m, moved), 0.0, 2e-16);
  }
}

TEST(Balance, OfNonOrthogonalSetsOfZeroStrengthIsTheProbe) {  // Fig. 5: earlier methods overshoot here
  Random random(8);
  for (int i = 0; i < 200; ++i) {
    Problem problem = random_problem(random, 4, false);
    for (Primitive& p : problem.primitives) p.strength_n = 0.0;
    EXPECT_NEAR(distance(solve(problem).position_m, problem.probe_m), 0.0, 1e-16);
  }
}

TEST(Balance, DragAloneGivesForceInProportionToSpeed) {  // f = c v
  Random random(9);
  for (int i = 0; i < 500; ++i) {
    const double c = random.uniform(0.1, 50), k = random.uniform(100, 2000), T = random.uniform(1e-4, 1e-2);
    const Vec3 x = random.in_cube(0.05);
    const Problem problem{{primitive(PrimitiveKind::point, x, {}, 0.0, c)}, x, x + random.in_cube(0.002), k, T};
    const Balance balance = solve(problem);
    const Vec3 velocity = (balance.position_m - x) / T;
    const Vec3 force_on_hand = k * (balance.position_m - problem.probe_m);
    EXPECT_NEAR(distance(force_on_hand, -c * velocity), 0.0, 1e-11);
  }
}

TEST(Balance, TotalForceNeverExceedsTheSumOfStrengths) {
  Random random(10);
  for (int i = 0; i < 3000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(8), false);
    const Balance balance = solve(problem);
    const double sum = std::accumulate(problem.primitives.begin(), problem.primitives.end(), 0.0,
                                       [](double a, const Primitive& p) { return a + p.strength_n; });
    EXPECT_LE(problem.stiffness_n_per_m * distance(balance.position_m, problem.probe_m),
              sum + 1e-9 + problem.stiffness_n_per_m * balance.error_bound_m);
  }
}

// The bound against an independent answer: long sweeps in long double from another start.
TEST(Bound, IsNeverExceeded) {
  Random random(11);
  int capped = 0;
  for (int i = 0; i < 2000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(5), i % 2 == 1);
    const Balance balance = solve(problem);
    capped += balance.status == BalanceStatus::capped;
    // Proximal-gradient-free reference: cyclic dual sweeps in 80-bit floats until nothing moves.
    struct L {
      long double x, y, z;
    };
    const auto dot3 = [](const L& a, const L& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
    const long double k = problem.stiffness_n_per_m, T = problem.time_step_s;
    std::vector<L> u(problem.primitives.size(), L{0, 0, 0});
    L x{problem.probe_m.x, problem.probe_m.y, problem.probe_m.z};
    for (std::size_t j = 0; j < u.size(); ++j) {
      const Primitive& p = problem.primitives[j];
      if (p.kind != PrimitiveKind::directed) continue;
      x.x += static_cast<long double>(p.strength_n) * p.direction.x / k;
      x.y += static_cast<long double>(p.strength_n) * p.direction.y / k;
      x.z += static_cast<long double>(p.strength_n) * p.direction.z / k;
    }
    for (int sweep = 0; sweep < 200000; ++sweep) {
      long double change = 0;
      for (std::size_t j = 0; j < u.size(); ++j) {
        const Primitive& p = problem.primitives[j];
        if (p.kind == PrimitiveKind::directed) continue;
        const L q{p.direction.x, p.direction.y, p.direction.z};
        const L without{x.x - u[j].x / k, x.y - u[j].y / k, x.z - u[j].z / k};
        L v{k * (p.position_m.x - without.x), k * (p.position_m.y - without.y), k * (p.position_m.z - without.z)};
        const long double along = dot3(v, q);
        if (p.kind == PrimitiveKind::line) v = {v.x - along * q.x, v.y - along * q.y, v.z - along * q.z};
        if (p.kind == PrimitiveKind::plane) {
          const long double t = std::max(0.0L, along);
          v = {t * q.x, t * q.y, t * q.z};
        }
        const long double n = std::sqrt(dot3(v, v)), s = p.strength_n, C = p.drag_ns_per_m / T;
        if (n > s) {
          const long double given = (s + (p.drag_ns_per_m > 0 ? C * (n - s) / (k + C) : 0.0L)) / n;
          v = {v.x * given, v.y * given, v.z * given};
        }
        change = std::max({change, std::fabs(v.x - u[j].x), std::fabs(v.y - u[j].y), std::fabs(v.z - u[j].z)});
        u[j] = v;
        x = {without.x + v.x / k, without.y + v.y / k, without.z + v.z / k};
      }
      if (change < 1e-17L) break;
    }
    const double error = static_cast<double>(std::sqrt((x.x - balance.position_m.x) * (x.x - balance.position_m.x) +
                                                       (x.y - balance.position_m.y) * (x.y - balance.position_m.y) +
                                                       (x.z - balance.position_m.z) * (x.z - balance.position_m.z)));
    EXPECT_LE(error, balance.error_bound_m + 1e-14) << "problem " << i;
  }
  EXPECT_LT(capped, 40);
}

TEST(Bound, GrowsWithTheDistanceFromTheBalance) {
  Random random(12);
  for (int i = 0; i < 1000; ++i) {
    const Problem problem = random_problem(random, 3, i % 2 == 1);
    PrimitiveSet set(4);
    fill(set, problem);
    Solver solver(4);
    const Balance balance = solver.solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
    const Vec3 off = random.in_cube(1e-4);
    const double bound = error_bound_m(set.primitives(), solver.forces_n(), balance.position_m + off, problem.probe_m,
                                       problem.stiffness_n_per_m, problem.time_step_s);
    EXPECT_GE(bound, norm(off) - balance.error_bound_m - 1e-15);
  }
}

TEST(Bound, IsTightAtTheProxy) {  // primitives through the proxy: every bound at most 1e-9 m
  Random random(13);
  for (int i = 0; i < 3000; ++i) {
    Problem problem = random_problem(random, 1 + random.below(2), false);
    for (Primitive& p : problem.primitives) p.position_m = problem.start_m;
    const Balance balance = solve(problem);
    EXPECT_LE(balance.error_bound_m, 1e-9);
  }
}

TEST(WarmStart, GivesTheSameBalanceAndMatchesPrimitivesByWhoPlacedThem) {
  Random random(14);
  Solver warm(16);
  PrimitiveSet set(16);
  for (int i = 0; i < 2000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(6), false);
    fill(set, problem);
    const Balance a = warm.solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, 1e-3);
    const Balance b = solve(problem);
    EXPECT_LE(distance(a.position_m, b.position_m), a.error_bound_m + b.error_bound_m);
  }
}

TEST(BadInput, KeepsTheStartAndGivesFiniteForces) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double inf = std::numeric_limits<double>::infinity();
  PrimitiveSet set(4);
  const Vec3 start{0.01, 0, 0};
  set.clear(start);
  set.point(0, start, 1.0, 2.0);
  Solver solver(4);
  const auto expect_refused = [&](const Vec3& probe, double k, double T) {
    const Balance balance = solver.solve(set, start, probe, k, T);
    EXPECT_EQ(balance.status, BalanceStatus::bad_input);
    EXPECT_EQ(balance.position_m, start);
    for (const Vec3& force : solver.forces_n()) EXPECT_EQ(force, Vec3{});
  };
  expect_refused({nan, 0, 0}, 800, 1e-3);
  expect_refused({inf, 0, 0}, 800, 1e-3);
  expect_refused({1e300, 0, 0}, 800, 1e-3);
  expect_refused({}, 0, 1e-3);
  expect_refused({}, -1, 1e-3);
  expect_refused({}, nan, 1e-3);
  expect_refused({}, 800, 0);
  expect_refused({}, 800, -1);
  expect_refused({}, 800, nan);
}

TEST(BadInput, ArbitraryBitsNeverGiveANonFiniteAnswer) {
  Random random(15);
  Solver solver(8);
  PrimitiveSet set(8);
  const auto any = [&] {
    const std::uint64_t bits = random.bits();
    double value;
    static_assert(sizeof value == sizeof bits);
    std::memcpy(&value, &bits, sizeof value);
    return random.below(3) == 0 ? value : random.uniform(-1, 1);
  };
  for (int i = 0; i < 20000; ++i) {
    const Vec3 start{any(), any(), any()};
    set.clear(start);
    for (int j = 0; j < 4; ++j) {
      set.add({test::random_kind(random),
               {0, static_cast<std::uint16_t>(j)},
               {any(), any(), any()},
               random.below(2) ? random.direction() : Vec3{any(), any(), any()},
               any(),
               random.below(2) ? 0.0 : any()});
    }
    const Balance balance = solver.solve(set, start, {any(), any(), any()}, any(), any());
    EXPECT_TRUE(is_finite(balance.position_m));
    EXPECT_TRUE(std::isfinite(balance.error_bound_m));
    for (const Vec3& force : solver.forces_n()) EXPECT_TRUE(is_finite(force));
  }
}

TEST(PrimitiveSet, RefusesWhatCannotBeSolvedAndNamesIt) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  PrimitiveSet set(2);
  set.clear({});
  set.begin_mode(7);
  const auto refused = [&](Refusal reason) {
    EXPECT_EQ(set.refused().back().reason, reason);
    EXPECT_EQ(set.refused().back().id.mode, 7);
  };
  set.point(0, {nan, 0, 0}, 1), refused(Refusal::position_not_finite);
  set.plane(0, {}, {0, 0, 1.0001}, 1), refused(Refusal::direction_not_unit);
  set.line(0, {}, {}, 1), refused(Refusal::direction_not_unit);
  set.point(0, {}, nan), refused(Refusal::strength_not_finite);
  set.point(0, {}, -1), refused(Refusal::strength_negative);
  set.point(0, {}, 1, nan), refused(Refusal::drag_not_finite);
  set.point(0, {}, 1, -1), refused(Refusal::drag_negative);
  set.point(0, {0.001, 0, 0}, 1, 2), refused(Refusal::drag_away_from_start);
  set.friction(1, 0, {}, 0.3), refused(Refusal::friction_without_plane);
  EXPECT_EQ(set.dropped(), 9);
  EXPECT_TRUE(set.empty());
  set.point(0, {}, 1);
  set.point(0, {}, 1), refused(Refusal::slot_used_twice);
  set.point(1, {}, 1);
  set.point(2, {}, 1), refused(Refusal::full);
  EXPECT_EQ(set.size(), 2u);
}

// Modes place at each foot in ignorance of the others: slots, planes with friction and starts of drags are those of the foot.
TEST(PrimitiveSet, KeepsFeetApart) {
  PrimitiveSet set;
  set.clear({});
  for (const std::uint16_t foot : {std::uint16_t{0}, std::uint16_t{1}}) {
    const Vec3 at_m{0.01 * foot, 0, 0};
    set.begin_foot(foot, at_m);
    set.begin_mode(3);
    set.plane(0, at_m, {0, 0, 1}, 1.0);
    set.friction(1, 0, at_m, 0.3);
    set.point(2, at_m, 0.0, 5.0);
    ASSERT_EQ(set.dropped(), 0);
    ASSERT_EQ(set.size(), 3u * (foot + 1u));
    EXPECT_EQ(set[set.size() - 1].id, (PrimitiveId{3, 2, foot}));
    EXPECT_EQ(set.row(static_cast<std::size_t>(set.friction_of(set.size() - 2).plane)), 3u * foot);
  }
  set.point(2, {0.01, 0, 0}, 1.0);
  set.begin_foot(2, {});
  set.friction(1, 0, {}, 0.3);
  EXPECT_EQ(set.refused().front().reason, Refusal::slot_used_twice);
  EXPECT_EQ(set.refused().back().reason, Refusal::friction_without_plane);
}

TEST(PrimitiveSet, AcceptsADragOnlyWhereItDissipates) {
  PrimitiveSet set(4);
  const Vec3 start{0.02, 0.01, 0.03};
  set.clear(start);
  set.point(0, start, 0, 2);
  set.line(1, start + Vec3{0, 0, 0.01}, {0, 0, 1}, 0, 2);
  set.plane(2, start - Vec3{0, 0, 0.01}, {0, 0, 1}, 0, {}, 2);
  EXPECT_EQ(set.dropped(), 0);
}

TEST(Norm, SurvivesOverflowAndUnderflow) {
  EXPECT_DOUBLE_EQ(norm({3e200, 4e200, 0}), 5e200);
  EXPECT_DOUBLE_EQ(norm({3e-200, 4e-200, 0}), 5e-200);
  EXPECT_NEAR(norm(normalized({1e300, 1e300, 1e300})), 1.0, 1e-15);
  EXPECT_NEAR(norm(normalized({1e-310, 0, 1e-310})), 1.0, 1e-14);
  EXPECT_EQ(normalized({}), Vec3{});
}

Motion way(const Vec3& way_m) { return {way_m, {}}; }

TEST(Damper, IsExactlyZeroInFreeSpaceAndNeverKicks) {
  Damper damper(0.5);
  damper.reset({});
  for (int i = 0; i < 100; ++i) EXPECT_EQ(damper.relative_velocity({}, {}, 1e-3, 800), Motion{});
  // A break-through of 5 mm in one tick, passed as a release, leaves no damper force of its own …
  Damper told(0.5);
  told.reset(way({0, 0, 0.005}));
  EXPECT_NEAR(length(told.relative_velocity(way({0, 0, 0.0001}), way({0, 0, -0.0049}), 1e-3, 800)), 0.0, 1e-12);
  // … and even without it the force stays within the larger of 0.2 N and half the spring's force.
  Damper untold(0.5);
  untold.reset(way({0, 0, 0.005}));
  EXPECT_LE(0.5 * length(untold.relative_velocity(way({0, 0, 0.0001}), {}, 1e-3, 800)), 0.2 + 1e-12);
}

TEST(Damper, FollowsASteadyMotion) {
  Damper damper(2.0);
  damper.reset({});
  Vec3 v;
  for (int i = 1; i <= 50; ++i) v = damper.relative_velocity(way({0, 0, -1e-5 * i}), {}, 1e-3, 3000).way_m;
  EXPECT_NEAR(v.z, -0.01, 1e-6);
}

}  // namespace solver_test
}  // namespace palpa
