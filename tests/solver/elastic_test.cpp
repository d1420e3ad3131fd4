// Elastic planes and corners: Huber's function of the distance, in series with the coupling.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpa/solver/coulomb_friction.h"
#include "palpa/solver/split.h"
#include "tests/solver/solved.h"

namespace palpa {
namespace elastic_test {

using test::Problem;
using test::Random;

constexpr double rigid = std::numeric_limits<double>::infinity();

/// A plane through the start, solid below, with the probe `depth_m` under it.
Problem pressed(Random& random, double strength_n, double stiffness_n_per_m, double depth_m) {
  Problem problem;
  problem.start_m = random.in_cube(0.05);
  problem.stiffness_n_per_m = random.uniform(100, 3000);
  const Vec3 normal = random.direction();
  problem.primitives = {{PrimitiveKind::plane, {}, problem.start_m, normal, strength_n, 0.0, stiffness_n_per_m}};
  problem.probe_m = problem.start_m - depth_m * normal;
  return problem;
}

TEST(Elastic, IsASpringBehindTheCouplingUpToItsStrength) {
  Random random(1);
  for (int i = 0; i < 5000; ++i) {
    const double strength_n = random.uniform(0.1, 5.0), level = std::exp(random.uniform(std::log(1.0), std::log(1e5)));
    const double depth_m = random.uniform(-0.001, 0.02);
    const Problem problem = pressed(random, strength_n, level, depth_m);
    const test::Solved found = test::solved(problem);
    const double k = problem.stiffness_n_per_m;
    const double in_series_n = std::max(0.0, depth_m) * k * level / (k + level);
    const double force_n = norm(found.forces_n[0]);
    EXPECT_NEAR(force_n, std::min(in_series_n, strength_n), 1e-9 * k);
    if (depth_m <= 0.0) continue;
    const double sunk_m = -dot(problem.primitives[0].direction, found.balance.position_m - problem.start_m);
    if (in_series_n < strength_n) {
      EXPECT_NEAR(sunk_m, force_n / level, 2e-9);
      EXPECT_EQ(state_at(problem.primitives[0], found.balance), PrimitiveState::stick);
    } else {
      EXPECT_NEAR(sunk_m, depth_m - strength_n / k, 2e-9);
      EXPECT_GE(sunk_m, strength_n / level - 2e-9);
    }
  }
}

TEST(Elastic, BecomesRigidAsItsStiffnessGrows) {
  Random random(2);
  for (const double level : {1e7, 1e9, 1e12, 1e300}) {
    for (int i = 0; i < 500; ++i) {
      Problem problem = test::random_problem(random, 1 + random.below(6), false);
      const test::Solved stiff = test::solved(problem);
      double strength_n = 0.0;
      for (Primitive& p : problem.primitives) {
        strength_n += p.strength_n;
        if (p.kind == PrimitiveKind::plane) p.stiffness_n_per_m = level;
      }
      const test::Solved soft = test::solved(problem);
      const double allowed_m = stiff.balance.error_bound_m + soft.balance.error_bound_m;
      // φ changes by at most s²/2κ each, and E is strongly convex.
      const double by_level_m = std::sqrt(2.0 * strength_n * strength_n / (level * problem.stiffness_n_per_m));
      EXPECT_LE(distance(stiff.balance.position_m, soft.balance.position_m), allowed_m + by_level_m);
    }
  }
}

// A holding primitive's force is its stiffness times the way out; a slipping one's, all its strength along that.
TEST(Elastic, SatisfiesTheInclusionPrimitiveByPrimitive) {
  for (const char* name : {"elastic_random", "elastic_haptic", "elastic_corner", "elastic_groove", "elastic_two_corners"}) {
    const test::Family& family = *test::family_named(name);
    int held = 0, slipped = 0;
    test::for_each_problem(family, false, {1, 3, 8, 16}, 100, [&](const test::Recipe& recipe) {
      const Problem problem = recipe.problem();
      const test::Solved found = test::solved(problem);
      for (std::size_t i = 0; i < problem.primitives.size();) {
        const std::size_t size =
            problem.primitives[i].kind == PrimitiveKind::corner ? whole_of(problem.primitives, i).size() : 1;
        const Primitive& p = problem.primitives[i];
        Vec3 force_n;
        for (std::size_t j = i; j < i + size; ++j) force_n += found.forces_n[j];
        if (p.is_elastic() && found.balance.status == BalanceStatus::exact) {
          const Vec3 way_m = residual(problem.primitives, i, found.balance.position_m);
          const double asked_n = p.stiffness_n_per_m * norm(way_m);
          const Vec3 should_n = asked_n > p.strength_n ? (p.strength_n / norm(way_m)) * way_m : p.stiffness_n_per_m * way_m;
          // A force's error follows from the position's error and the gap.
          const double error_m = found.balance.error_bound_m + 1e-15;
          const double allowed_n = 2e-9 * (problem.stiffness_n_per_m + p.stiffness_n_per_m) +
                                   2.0 * error_m * std::sqrt(problem.stiffness_n_per_m * p.stiffness_n_per_m);
          EXPECT_LE(distance(force_n, should_n), allowed_n) << recipe << ", primitive " << i;
          (asked_n > p.strength_n ? slipped : held) += norm(force_n) > 1e-6;
        }
        i += size;
      }
    });
    EXPECT_GT(held, 20) << name;
    EXPECT_GT(slipped, 20) << name;
  }
}

// Two at one point share a load by their stiffnesses; no other split is possible.
TEST(Elastic, SharesALoadByStiffness) {
  Random random(4);
  for (int i = 0; i < 500; ++i) {
    Problem problem = pressed(random, 50.0, random.uniform(100, 2000), 0.004);
    Primitive second = problem.primitives[0];
    second.id.slot = 1;
    second.stiffness_n_per_m = random.uniform(100, 2000);
    problem.primitives.push_back(second);
    test::Solved found = test::solved(problem);
    const double ratio = norm(found.forces_n[0]) / norm(found.forces_n[1]);
    EXPECT_NEAR(ratio, problem.primitives[0].stiffness_n_per_m / second.stiffness_n_per_m, 1e-5 * ratio);
    EXPECT_FALSE(split_is_shared(problem.primitives, found.balance));
    const std::vector<Vec3> before = found.forces_n;
    least_split(problem.primitives, found.balance, found.forces_n);
    EXPECT_EQ(before, found.forces_n);
  }
}

// Fixed elastic primitives return their energy: the force is that of a potential, to the order of the hold.
TEST(Elastic, GivesBackWhatItTook) {
  Random random(5);
  for (int i = 0; i < 50; ++i) {
    Problem problem = pressed(random, 10.0, random.uniform(50, 5000), 0.0);
    const Vec3 axis = random.direction(), across = normalized(cross(axis, random.direction()));
    const auto work_j = [&](int ticks) {
      double work = 0.0;
      Vec3 before_m, before_n;
      for (int tick = 0; tick <= ticks; ++tick) {
        const double turn = 2.0 * M_PI * tick / ticks;
        problem.probe_m = problem.start_m + 0.004 * (std::cos(turn) * axis + std::sin(turn) * across);
        const Vec3 force_n = problem.stiffness_n_per_m * (test::solved(problem).balance.position_m - problem.probe_m);
        if (tick > 0) work += dot(0.5 * (force_n + before_n), problem.probe_m - before_m);
        before_m = problem.probe_m, before_n = force_n;
      }
      return std::abs(work);
    };
    const double coarse_j = work_j(100), fine_j = work_j(400);
    EXPECT_LE(fine_j, 0.25 * coarse_j + 1e-9);
    EXPECT_LE(fine_j, 1e-5);
  }
}

// Planes may turn and move between two ticks: while they leave the old footing free the stored energy does not grow, and hand
// and level together inject only the hold's energy (theory.md 7.8).
TEST(Elastic, BringsNothingInWhereEveryPlaneLeavesTheOldFootingFree) {
  Random random(6);
  for (int run = 0; run < 200; ++run) {
    Problem problem = pressed(random, random.uniform(0.5, 5.0), random.uniform(50, 5000), 0.003);
    Primitive& plane = problem.primitives[0];
    const double k = problem.stiffness_n_per_m, level = plane.stiffness_n_per_m;
    Vec3 proxy_m = problem.start_m, footing_m = proxy_m, probe_m = proxy_m;
    double stored_j = 0.0;
    for (int tick = 0; tick < 200; ++tick) {
      plane.direction = normalized(plane.direction + 0.2 * random.in_cube(1.0));
      plane.position_m = footing_m - random.uniform(0.0, 1e-4) * plane.direction;
      problem.start_m = proxy_m;
      problem.probe_m = probe_m + random.in_cube(0.0005);
      const Vec3 force_n = k * (proxy_m - probe_m);
      const test::Solved found = test::solved(problem);
      proxy_m = found.balance.position_m;
      const Vec3 way_m = residual(plane, proxy_m);
      footing_m = proxy_m + shortened(way_m, plane.strength_n / level);
      const double held_n = std::min(level * norm(way_m), plane.strength_n);
      const double now_j = 0.5 * k * norm_squared(proxy_m - problem.probe_m) + 0.5 * held_n * held_n / level;
      const Vec3 step_m = problem.probe_m - probe_m;
      EXPECT_LE(dot(force_n, step_m), stored_j - now_j + 0.5 * k * norm_squared(step_m) + 1e-12) << run << ", " << tick;
      stored_j = now_j;
      probe_m = problem.probe_m;
    }
  }
}

// The footing is offset against its force by at most its largest deflection.
TEST(Elastic, ItsFootingIsAsFarOffAsItsForceOverItsStiffness) {
  for (const char* name : {"elastic_random", "elastic_haptic", "elastic_corner", "elastic_groove"}) {
    int sunk = 0;
    test::for_each_problem(*test::family_named(name), false, {1, 3, 8}, 100, [&](const test::Recipe& recipe) {
      const Problem problem = recipe.problem();
      const test::Solved found = test::solved(problem);
      for (std::size_t i = 0; i < problem.primitives.size(); ++i) {
        const Primitive& p = problem.primitives[i];
        const std::span<const Primitive> whole = whole_of(problem.primitives, i);
        if (whole.data() != &p) continue;
        const Vec3 way_m = way_to_footing_m(problem.primitives, i, found.balance.position_m);
        if (!p.is_elastic()) {
          EXPECT_EQ(way_m, Vec3{}) << recipe;
          continue;
        }
        Vec3 force_n;
        for (std::size_t facet = 0; facet < whole.size(); ++facet) force_n += found.forces_n[i + facet];
        const double longest_m = p.strength_n / p.stiffness_n_per_m;
        EXPECT_LE(norm(way_m), longest_m * (1.0 + 1e-12)) << recipe;
        // Forces are as exact as the proxy times a spring, and up to a direction when slipping.
        const double off_n = p.stiffness_n_per_m * (found.balance.error_bound_m + 1e-12) + 1e-9 * p.strength_n;
        if (norm(force_n) > 0.999 * p.strength_n || off_n > 0.01 * p.strength_n) continue;
        EXPECT_LE(distance(p.stiffness_n_per_m * way_m, force_n), 3.0 * off_n) << recipe;
        sunk += norm(force_n) > 0.0;
      }
    });
    EXPECT_GT(sunk, 20) << name;
  }
}

TEST(Elastic, LetsFrictionKnowWhatItBears) {
  Random random(7);
  for (int i = 0; i < 500; ++i) {
    const double level = random.uniform(50, 5000), depth_m = random.uniform(0.0001, 0.01),
                 coefficient = random.uniform(0.1, 1.0);
    const Problem problem = pressed(random, 4.0, level, depth_m);
    const Primitive& plane = problem.primitives[0];
    PrimitiveSet set(8);
    set.clear(problem.start_m);
    set.elastic_plane(0, plane.position_m, plane.direction, plane.strength_n, level);
    set.friction(1, 0, problem.start_m, coefficient);
    StateArena block;
    CoulombFriction friction(block, 8);
    const Tool point;
    ToolLaw law(std::make_unique<Solver>(8), point, 8);
    const Vec3 probe_m = problem.probe_m + 0.02 * normalized(cross(plane.direction, random.direction()));
    friction.solve(law, set, {probe_m, {}}, problem.stiffness_n_per_m, 1e-3);
    const double pressed_n = norm(law.forces_n()[0]);
    EXPECT_NEAR(norm(law.forces_n()[1]), coefficient * pressed_n, 1e-8);
    const double k = problem.stiffness_n_per_m;
    EXPECT_NEAR(pressed_n, std::min(depth_m * k * level / (k + level), 4.0), 1e-8);
  }
}

TEST(Elastic, FallsByHubersFunction) {
  Random random(8);
  for (int i = 0; i < 200; ++i) {
    const Primitive plane{PrimitiveKind::plane, {}, {}, {0, 0, 1}, random.uniform(0.1, 3), 0.0, random.uniform(10, 5000)};
    const Vec3 from_m = random.in_cube(0.01), to_m = random.in_cube(0.01);
    const int pieces = 20000;
    double work_j = 0.0;
    for (int n = 0; n < pieces; ++n) {
      const double z = from_m.z + (n + 0.5) / pieces * (to_m.z - from_m.z);
      work_j += std::clamp(-z * plane.stiffness_n_per_m, 0.0, plane.strength_n) * (to_m.z - from_m.z) / pieces;
    }
    EXPECT_NEAR(fall_j(plane, from_m, to_m, 1e-3), work_j, 1e-6 * (1.0 + std::abs(work_j)));
  }
}

TEST(Elastic, IsRefusedWhereItMeansNothing) {
  const auto refusal = [](Primitive p) {
    PrimitiveSet set(8);
    set.clear({});
    set.add(p);
    return set.refused().empty() ? "" : sentence_of(set.refused()[0].reason);
  };
  const Primitive plane{PrimitiveKind::plane, {}, {}, {0, 0, 1}, 1.0, 0.0, 100.0};
  EXPECT_STREQ(refusal(plane), "");
  for (const double stiffness : {0.0, -1.0, std::nan(""), -rigid, 1e-13}) {
    Primitive p = plane;
    p.stiffness_n_per_m = stiffness;
    EXPECT_STREQ(refusal(p), "stiffness is not above 1e-12 N/m") << stiffness;
  }
  for (const PrimitiveKind kind : {PrimitiveKind::point, PrimitiveKind::line, PrimitiveKind::directed}) {
    Primitive p = plane;
    p.kind = kind;
    EXPECT_STREQ(refusal(p), "stiffness is of what is no plane");
  }
  Primitive p = plane;
  p.drag_ns_per_m = 1.0;
  EXPECT_STREQ(refusal(p), "stiffness is of a plane with drag");
}

}  // namespace elastic_test
}  // namespace palpa
