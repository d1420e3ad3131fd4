// Promises and known errors of earlier systems' laws.
#include "palpa/baseline/law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "palpa/scene/keys.h"
#include "tests/baseline/paper_readings.h"
#include "tests/solver/counted_allocations.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace law_test {

using test::fill;
using test::Problem;
using test::Random;
using test::random_problem;

const std::vector<std::string> earlier{"paper-2005", "ikits-2003", "ikits-2003-sequential", "no-proxy"};

std::unique_ptr<Law> law(const std::string& method) {
  Scene scene;
  scene.set_law(method);
  return baseline::law(scene.law());
}

Balance solve(Law& law, const Problem& problem) {
  PrimitiveSet set(64);
  fill(set, problem);
  EXPECT_EQ(set.dropped(), 0);
  return law.solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
}

Balance solve(const std::string& method, const Problem& problem) { return solve(*law(method), problem); }

double error_m(const std::string& method, const Problem& problem) {
  return distance(solve(method, problem).position_m, solve("exact", problem).position_m);
}

void add(Problem& problem, PrimitiveKind kind, const Vec3& direction, double strength, double drag = 0.0) {
  const auto slot = static_cast<std::uint16_t>(problem.primitives.size());
  problem.primitives.push_back({kind, {0, slot}, problem.start_m, direction, strength, drag});
}

Problem free_problem(Random& random) {
  Problem problem;
  problem.start_m = random.in_cube(0.05);
  problem.probe_m = problem.start_m + random.in_cube(0.004);
  problem.stiffness_n_per_m = random.uniform(300, 3000);
  return problem;
}

struct Errors {
  double over_1um_share = 0.0;
  double p99_m = 0.0;
  double rms_m = 0.0;
};

Errors errors_of(std::vector<double> each_m) {
  std::sort(each_m.begin(), each_m.end());
  Errors errors;
  for (const double e : each_m) {
    errors.rms_m += e * e / static_cast<double>(each_m.size());
    errors.over_1um_share += (e > 1e-6 ? 1.0 : 0.0) / static_cast<double>(each_m.size());
  }
  errors.rms_m = std::sqrt(errors.rms_m);
  errors.p99_m = each_m[each_m.size() * 99 / 100];
  return errors;
}

TEST(BaselineLaw, IsFoundByTheNameThatASceneGives) {
  Scene scene;
  EXPECT_NE(baseline::law(scene.law()), nullptr);
  for (const std::string& method : earlier) {
    scene.set_law(method);
    EXPECT_NE(baseline::law(scene.law()), nullptr) << method;
  }
  EXPECT_EQ(baseline::law("ikits-2004"), nullptr);
}

TEST(BaselineLaw, WithoutPrimitivesIsTheProbeItself) {
  Random random(1);
  for (const std::string& method : earlier) {
    const Problem problem = random_problem(random, 0, false);
    const Balance balance = solve(method, problem);
    EXPECT_EQ(balance.position_m, problem.probe_m);
    EXPECT_EQ(balance.error_bound_m, 0.0);
    EXPECT_EQ(balance.status, BalanceStatus::baseline);
  }
}

TEST(BaselineLaw, BoundHoldsTheDistanceToTheExactBalance) {
  Random random(2);
  for (int i = 0; i < 4000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(7), i % 2 == 1);
    const Balance exact = solve("exact", problem);
    for (const std::string& method : earlier) {
      const Balance balance = solve(method, problem);
      EXPECT_EQ(balance.status, BalanceStatus::baseline);
      EXPECT_LE(distance(balance.position_m, exact.position_m), balance.error_bound_m + exact.error_bound_m)
          << method << " problem " << i;
    }
  }
}

TEST(BaselineLaw, BoundIsThatOfItsForces) {
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(7), i % 2 == 1);
    for (const std::string& method : earlier) {
      const auto found = law(method);
      const Balance balance = solve(*found, problem);
      ASSERT_EQ(found->forces_n().size(), problem.primitives.size());
      EXPECT_EQ(balance.error_bound_m, error_bound_m(problem.primitives, found->forces_n(), balance.position_m, problem.probe_m,
                                                     problem.stiffness_n_per_m, problem.time_step_s));
    }
  }
}

// With directed forces alone every law must return probe + force/k: that unites proxy and force functions.
TEST(BaselineLaw, AgreesWithTheExactOneOnDirectedForces) {
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    Problem problem = free_problem(random);
    for (int j = random.below(4); j >= 0; --j) add(problem, PrimitiveKind::directed, random.direction(), random.uniform(0, 2));
    for (const std::string& method : earlier) EXPECT_LT(error_m(method, problem), 1e-12) << method;
  }
}

// Results and forces are finite and within reach for any set and any call.
TEST(BaselineLaw, IsFiniteOnEveryInput) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Random random(5);
  const auto any_of = [&](std::initializer_list<double> values) {
    return *(values.begin() + random.below(static_cast<int>(values.size())));
  };
  for (const std::string& method : earlier) {
    const auto found = law(method);
    PrimitiveSet set(64);
    for (int i = 0; i < 6000; ++i) {
      const int n = i % 50 == 0 ? 64 : i % 50 == 1 ? 0 : random.below(9);
      Problem problem = random_problem(random, n, true);
      if (i % 3 == 0) problem.start_m = any_of({0.0, 1e-300, 1e-3, 1e6}) * random.direction();
      for (Primitive& p : problem.primitives) {
        if (random.below(3) == 0) p.strength_n = any_of({0.0, 1e-300, 1e-9, 1.0, 1e9});
        if (random.below(3) == 0) p.position_m = any_of({0.0, 1e-300, 1e-6, 1e3, 5e5}) * random.direction();
        if (random.below(3) == 0) p.position_m = problem.start_m, p.drag_ns_per_m = any_of({1e-300, 1.0, 1e9});
        if (p.kind == PrimitiveKind::directed) p.drag_ns_per_m = 0.0;
      }
      fill(set, problem);
      Vec3 probe = problem.probe_m;
      if (random.below(3) == 0) probe = any_of({0.0, 1e-12, 1.0, 1e6}) * random.direction();
      double k = random.below(3) == 0 ? any_of({1e-300, 1e-6, 1.0, 1e12}) : problem.stiffness_n_per_m;
      double T = random.below(3) == 0 ? any_of({1e-15, 1e-9, 1.0, 1e9}) : problem.time_step_s;
      const bool bad = i % 10 == 9;
      if (bad) {
        switch (random.below(4)) {
          case 0: probe.y = any_of({nan, inf, -inf, 1e300}); break;
          case 1: problem.start_m.z = any_of({nan, inf, 2e6}); break;
          case 2: k = any_of({0.0, -1.0, nan, inf}); break;
          default:
            T = any_of({0.0, -1.0, nan, inf});
            add(problem, PrimitiveKind::point, {}, 1.0, 1.0);
            fill(set, problem);
        }
      }
      const Balance balance = found->solve(set, problem.start_m, probe, k, T);
      if (bad && set.size() == problem.primitives.size()) {
        ASSERT_EQ(balance.status, BalanceStatus::bad_input) << method << " " << i;
      }
      ASSERT_TRUE(is_finite(balance.position_m)) << method << " " << i;
      ASSERT_LE(largest_component(balance.position_m), largest_position_m) << method << " " << i;
      ASSERT_TRUE(std::isfinite(balance.error_bound_m) && balance.error_bound_m >= 0.0) << method << " " << i;
      ASSERT_EQ(found->forces_n().size(), set.size());
      for (const Vec3& force : found->forces_n()) ASSERT_TRUE(is_finite(force)) << method << " " << i;
      if (random.below(20) == 0) found->reset();
    }
  }
}

TEST(BaselineLaw, AnswersBadInputAsTheExactOne) {
  Random random(6);
  const Problem good = random_problem(random, 4, true);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (int what = 0; what < 4; ++what) {
    Problem problem = good;
    PrimitiveSet set(64);
    fill(set, problem);
    if (what == 0) problem.probe_m.x = nan;
    if (what == 1) problem.start_m.x = nan;
    if (what == 2) problem.stiffness_n_per_m = -1.0;
    if (what == 3) problem.probe_m.x = 2e6;
    const auto balance_of = [&](const std::string& method) {
      return law(method)->solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
    };
    const Balance exact = balance_of("exact");
    ASSERT_EQ(exact.status, BalanceStatus::bad_input);
    for (const std::string& method : earlier) {
      const Balance balance = balance_of(method);
      EXPECT_EQ(balance.status, BalanceStatus::bad_input) << method;
      EXPECT_EQ(balance.position_m, exact.position_m) << method;
      EXPECT_EQ(balance.error_bound_m, exact.error_bound_m) << method;
    }
  }
}

TEST(BaselineLaw, AllocatesNothingInSolve) {
  Random random(7);
  for (const std::string& method : earlier) {
    const auto found = law(method);
    PrimitiveSet set(64);
    for (int i = 0; i < 200; ++i) {
      const Problem problem = random_problem(random, i % 65, true);
      fill(set, problem);
      const long before = test::allocations;
      found->solve(set, problem.start_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
      if (i % 7 == 0) found->reset();
      EXPECT_EQ(test::allocations, before) << method;
    }
  }
}

// ---- ikits-2003

// Mutually orthogonal spans at the proxy, where the 2003 update is the exact balance: three planes; plane and line with one
// direction (surface and friction); either with points, which act on the whole motion.
TEST(Ikits2003, IsExactOnMutuallyOrthogonalSets) {
  Random random(10);
  for (int i = 0; i < 5000; ++i) {
    Problem problem = free_problem(random);
    const Mat3 axes = random.rotation();
    const bool points = i % 3 == 2;
    const auto strength = [&] { return random.below(4) == 0 ? 0.0 : random.uniform(0, 4); };
    const auto drag = [&] { return !points && random.below(3) == 0 ? random.uniform(0, 5) : 0.0; };
    const int planes = random.below(4);
    for (int a = 0; a < planes; ++a) {
      add(problem, PrimitiveKind::plane, random.below(2) ? axes.row[a] : -axes.row[a], strength(), drag());
    }
    if (planes <= 1) add(problem, PrimitiveKind::line, axes.row[0], strength(), drag());
    if (points) {
      add(problem, PrimitiveKind::point, {}, strength());
      add(problem, PrimitiveKind::point, {}, strength());
    }
    if (random.below(2)) add(problem, PrimitiveKind::directed, random.direction(), random.uniform(0, 2));
    for (const char* method : {"ikits-2003", "ikits-2003-sequential"}) {
      ASSERT_LT(error_m(method, problem), 1e-9) << method << " problem " << i;
      if (!points) {
        ASSERT_LT(error_m(method, problem), 1e-15) << method << " problem " << i;
      }
      ASSERT_LT(solve(method, problem).error_bound_m, 1e-8) << method << " problem " << i;
    }
  }
}

TEST(Ikits2003, IsExactOnEverySinglePrimitive) {
  Random random(11);
  for (int i = 0; i < 3000; ++i) {
    const Problem problem = random_problem(random, 1, i % 2 == 1);
    EXPECT_LT(error_m("ikits-2003", problem), 1e-15);
    EXPECT_LT(error_m("ikits-2003-sequential", problem), 1e-15);
  }
}

// Paper, Fig. 5: two axes of zero strength at an angle θ. The proxy should reach the probe and misses it by |cos θ| |d|, for
// every d in their plane: beyond it along the bisector, short of it across.
TEST(Ikits2003, MissesTheProbeByTheCosineOfTheAngleBetweenTwoFreeAxes) {
  Random random(12);
  for (int i = 0; i < 5000; ++i) {
    const double angle = random.uniform(0.01, std::numbers::pi - 0.01);
    const Mat3 frame = random.rotation();
    const Vec3 e1 = frame.row[0];
    const Vec3 e2 = std::cos(angle) * frame.row[0] + std::sin(angle) * frame.row[1];
    Problem problem = free_problem(random);
    const Vec3 d = random.uniform(-2e-3, 2e-3) * frame.row[0] + random.uniform(-2e-3, 2e-3) * frame.row[1];
    const Vec3 across = random.uniform(-1e-3, 1e-3) * frame.row[2];  // spanned by no axis: follows
    problem.probe_m = problem.start_m + d + across;
    add(problem, PrimitiveKind::plane, normalized(e1), 0.0);
    add(problem, PrimitiveKind::plane, normalized(e2), 0.0);
    const Vec3 miss = solve("ikits-2003", problem).position_m - problem.probe_m;
    EXPECT_NEAR(norm(miss), std::abs(std::cos(angle)) * norm(d), 1e-12 * norm(d) + 1e-16);
    EXPECT_LT(distance(solve("exact", problem).position_m, problem.probe_m), 1e-15);

    const Vec3 bisector = normalized(e1 + e2);
    problem.probe_m = problem.start_m + 1e-3 * bisector;
    const Vec3 moved = solve("ikits-2003", problem).position_m - problem.start_m;
    EXPECT_NEAR(dot(moved, bisector), 1e-3 * (1.0 + std::cos(angle)), 1e-12);
  }
}

// Three axes with equal mutual angles have an eigenvalue 1 + 2 cos: below 60° the error grows from tick to tick.
TEST(Ikits2003, DivergesOnThreeAxesLessThan60DegreesApart) {
  const auto last_error_m = [](double degrees) {
    const double c = std::cos(degrees * std::numbers::pi / 180.0);
    const double tilt = std::sqrt(2.0 * (1.0 - c) / 3.0);  // of each axis, from the common axis
    Problem problem;
    problem.probe_m = {0, 0, 1e-3};
    for (int tick = 0; tick < 20; ++tick) {
      problem.primitives.clear();
      for (int a = 0; a < 3; ++a) {
        const double turn = 2.0 * std::numbers::pi * a / 3.0;
        const Vec3 axis{tilt * std::cos(turn), tilt * std::sin(turn), std::sqrt(1.0 - tilt * tilt)};
        add(problem, PrimitiveKind::plane, normalized(axis), 0.0);
      }
      problem.start_m = solve("ikits-2003", problem).position_m;
    }
    return distance(problem.start_m, problem.probe_m);
  };
  EXPECT_LT(last_error_m(75), 1e-6);
  EXPECT_NEAR(last_error_m(60), 1e-3, 1e-9);
  EXPECT_NEAR(last_error_m(45) / (1e-3 * std::pow(2.0 * std::cos(std::numbers::pi / 4), 20)), 1.0, 1e-6);
}

TEST(Ikits2003Sequential, DependsOnTheOrderAndIsExactForItsLastConstraint) {
  Problem problem;
  problem.probe_m = {2e-3, 0.5e-3, 1e-3};
  const Vec3 e1{1, 0, 0};
  const Vec3 e2 = normalized(Vec3{1, 1, 0});
  add(problem, PrimitiveKind::plane, e1, 0.0);
  add(problem, PrimitiveKind::plane, e2, 0.0);
  const Vec3 one = solve("ikits-2003-sequential", problem).position_m - problem.probe_m;
  std::swap(problem.primitives[0].direction, problem.primitives[1].direction);
  const Vec3 other = solve("ikits-2003-sequential", problem).position_m - problem.probe_m;
  EXPECT_NEAR(dot(one, e2), 0.0, 1e-18);
  EXPECT_NEAR(dot(other, e1), 0.0, 1e-18);
  EXPECT_GT(distance(one, other), 1e-4);
  const double error = error_m("ikits-2003", problem);
  std::swap(problem.primitives[0].direction, problem.primitives[1].direction);
  EXPECT_NEAR(error_m("ikits-2003", problem), error, 1e-18);
}

// Two rails at a small angle: along them both axes have little, so a free proxy lags by cos of the way in one tick.
TEST(Ikits2003Sequential, LagsAlongTwoFreeRailsThatAreNearlyParallel) {
  const double angle = 0.1;
  Problem problem;
  add(problem, PrimitiveKind::line, {1, 0, 0}, 0.0);
  add(problem, PrimitiveKind::line, normalized(Vec3{std::cos(angle), std::sin(angle), 0}), 0.0);
  problem.probe_m = {1e-3, 0, 0};
  EXPECT_NEAR(error_m("ikits-2003-sequential", problem), std::cos(angle) * 1e-3, 1e-12);
  EXPECT_NEAR(error_m("ikits-2003", problem), std::cos(angle) * 1e-3, 1e-12);
}

// With zero strengths each move takes a projection from the remaining path: never more than all of it.
TEST(Ikits2003Sequential, LeavesNoMoreThanTheWholeWayOnFreeAxes) {
  Random random(13);
  for (int i = 0; i < 2000; ++i) {
    Problem problem = free_problem(random);
    for (int j = 2 + random.below(4); j > 0; --j) add(problem, PrimitiveKind::plane, random.direction(), 0.0);
    EXPECT_LE(error_m("ikits-2003-sequential", problem), distance(problem.start_m, problem.probe_m) + 1e-15);
  }
}

// ---- paper-2005

TEST(Paper2005, IsTheBestOfThreeReadings) {
  Random random(20);
  std::vector<double> ours, residual_falls, energy_falls;
  for (int i = 0; i < 10000; ++i) {
    const Problem problem = random_problem(random, 1 + random.below(8), i % 2 == 1);
    const Balance exact = solve("exact", problem);
    if (exact.status != BalanceStatus::exact) continue;
    const test::Posed posed{problem.primitives, problem.start_m, problem.probe_m, problem.stiffness_n_per_m,
                            problem.time_step_s};
    ours.push_back(distance(solve("paper-2005", problem).position_m, exact.position_m));
    residual_falls.push_back(distance(proxy_by(test::Reading::residual_falls, posed, 200), exact.position_m));
    energy_falls.push_back(distance(proxy_by(test::Reading::energy_falls, posed, 200), exact.position_m));
  }
  const Errors errors = errors_of(ours);
  const auto print = [](const char* name, const Errors& e) {
    std::printf("%-22s above 1 um %4.1f %%, p99 %.2f mm, rms %.3f mm\n", name, 100 * e.over_1um_share, 1e3 * e.p99_m,
                1e3 * e.rms_m);
  };
  print("halved on reversal", errors);
  for (const auto& [name, other] :
       {std::pair{"|f_res| falls", errors_of(residual_falls)}, std::pair{"energy falls", errors_of(energy_falls)}}) {
    print(name, other);
    EXPECT_LT(errors.p99_m, other.p99_m) << name;
    EXPECT_LT(errors.rms_m, other.rms_m) << name;
  }
}

// Smooth problems without sticking converge.
TEST(Paper2005, FindsTheBalanceAwayFromAllKinks) {
  Random random(21);
  for (int i = 0; i < 500; ++i) {
    Problem problem = free_problem(random);
    for (int j = 0; j < 3; ++j) {
      add(problem, PrimitiveKind::point, {}, random.uniform(0.01, 0.3));
      problem.primitives.back().position_m += 0.05 * random.direction();
    }
    EXPECT_LT(error_m("paper-2005", problem), 1e-9);
  }
}

// The error at kinks, on a surface with friction, pressed and slid along, is above a hand's threshold.
TEST(Paper2005, IsOffOnASurfaceWithFriction) {
  Random random(22);
  std::vector<double> errors_m;
  for (int i = 0; i < 2000; ++i) {
    Problem problem = free_problem(random);
    const Vec3 normal = random.direction();
    add(problem, PrimitiveKind::plane, normal, 3.0);
    add(problem, PrimitiveKind::line, normal, 0.5);
    problem.probe_m = problem.start_m - 1.5e-3 * normal + 1e-3 * normalized(cross(normal, random.direction()));
    errors_m.push_back(error_m("paper-2005", problem));
  }
  const Errors errors = errors_of(errors_m);
  std::printf("surface with friction: above 1 um %4.1f %%, p99 %.3f mm\n", 100 * errors.over_1um_share, 1e3 * errors.p99_m);
  EXPECT_GT(errors.p99_m, 1e-4);
}

// ---- no-proxy

TEST(NoProxy, GivesTheForceFunctionThroughTheCoupling) {
  Random random(30);
  for (int i = 0; i < 1000; ++i) {
    const double k = random.uniform(300, 3000);
    const Vec3 probe = random.in_cube(0.05);
    const Vec3 v = random.in_cube(0.2);
    const Vec3 q = random.direction();
    const double s = random.uniform(0.1, 2);
    const double c = random.uniform(0, 2);
    const double T = 1e-3;
    const auto force_of = [&](const Primitive& p) {
      const auto found = law("no-proxy");
      PrimitiveSet set;
      set.clear(probe);
      set.add(p);
      EXPECT_EQ(set.dropped(), 0);
      found->solve(set, probe, probe - T * v, k, T);
      const Vec3 start = probe + Vec3{1e-3, 0, 0};
      const Balance first = found->solve(set, start, probe, k, T);
      const Balance again = found->solve(set, start, probe, k, T);  // friction's second pass: no motion
      EXPECT_EQ(first.position_m, again.position_m);
      return k * (first.position_m - probe);
    };
    EXPECT_LT(distance(force_of({PrimitiveKind::directed, {}, {}, q, s}), s * q), 1e-10);
    EXPECT_LT(distance(force_of({PrimitiveKind::point, {}, probe, {}, s, c}), -s * normalized(v) - c * v), 1e-10);
    const Vec3 across = v - dot(q, v) * q;
    EXPECT_LT(distance(force_of({PrimitiveKind::line, {}, probe, q, s, c}), -s * normalized(across) - c * across), 1e-10);
    const double depth = random.uniform(-2e-3, 5e-3);
    const double push = std::clamp(k * depth, 0.0, s);
    EXPECT_LT(distance(force_of({PrimitiveKind::plane, {}, probe + depth * q, q, s}), push * q), 1e-10);
  }
}

TEST(NoProxy, ForgetsTheMotionWhenItIsReset) {
  const auto found = law("no-proxy");
  PrimitiveSet set;
  set.clear({});
  set.point(0, {}, 1.0, 1.0);
  found->solve(set, {}, {}, 800, 1e-3);
  EXPECT_LT(found->solve(set, {}, {1e-3, 0, 0}, 800, 1e-3).position_m.x, 1e-3);
  found->reset();
  EXPECT_EQ(found->solve(set, {}, {2e-3, 0, 0}, 800, 1e-3).position_m, (Vec3{2e-3, 0, 0}));
}

}  // namespace law_test
}  // namespace palpa
