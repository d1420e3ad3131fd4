// Laws of the corner, s times the distance to the points that all its facets leave free (docs/theory.md, section 8).
#include "palpa/solver/corner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "palpa/solver/law.h"
#include "tests/solver/all_faces.h"
#include "tests/solver/solved.h"

namespace palpa::test {
namespace corner_test {

TEST(Corner, ItsWayOutIsThatOfAllFacesTriedOneByOne) {
  Random random(1);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 x_m = random.in_cube(0.05);
    const Facets facets = some_facets(random, x_m, random.below(2) == 0 ? 0.0 : 0.003, 1 + random.below(8));
    Problem problem;
    add_corner(problem, facets, 1.0);
    const Vec3 off_m = random.in_cube(0.003);
    const Vec3 expected_m = way_out_by_all_faces(facets, x_m + off_m);
    EXPECT_LE(distance(residual(problem.primitives, 0, x_m + off_m), expected_m), 1e-14) << i;
    EXPECT_EQ(residual(problem.primitives, facets.size() - 1, x_m + off_m), residual(problem.primitives, 0, x_m + off_m));
  }
}

// Whichever face the search begins with.
TEST(Corner, ItsLeastWayIsThatOfASearchWithoutAGuess) {
  Random random(3);
  int kept = 0, left = 0;
  for (int i = 0; i < 20000; ++i) {
    std::vector<Vec3> normals;
    std::vector<double> before, c;
    const int facets = 1 + random.below(8);
    const double change = std::pow(10.0, random.uniform(-16.0, 1.0));
    for (const Facet& facet : some_facets(random, {}, 0.003, facets)) {
      normals.push_back(facet.normal);
      before.push_back(random.uniform(-1.0, 1.0));
      c.push_back(before.back() + change * random.uniform(-1.0, 1.0));
    }
    const detail::LeastWay guess = detail::least_way(normals, before.data());
    const detail::LeastWay from_guess = detail::least_way(normals, c.data(), guess.face);
    const detail::LeastWay expected = detail::least_way(normals, c.data());
    ASSERT_EQ(from_guess.found, expected.found) << i;
    if (!expected.found) continue;
    const double size = norm(expected.w) + change;
    ASSERT_LE(distance(from_guess.w, expected.w), 1e-13 * (1.0 + size) * expected.face.inverse_norm() + 1e-13) << i;
    const detail::LeastWay again = detail::least_way(normals, c.data(), expected.face);
    ASSERT_EQ(again.w, expected.w) << i << ": its own face gives it to the bit";
    const bool is_kept = from_guess.face.size == guess.face.size && std::ranges::equal(from_guess.face.facet, guess.face.facet);
    (is_kept ? kept : left) += guess.face.size > 0;
  }
  EXPECT_GT(kept, 1000);
  EXPECT_GT(left, 1000);
}

TEST(Corner, HoldsWhileTheStiffnessTimesTheDistanceIsWithinItsStrengthThenLetsGoAsAWhole) {
  Random random(2);
  for (int i = 0; i < 5000; ++i) {
    Problem problem;
    problem.start_m = random.in_cube(0.05);
    problem.stiffness_n_per_m = random.uniform(100, 3000);
    const Facets facets = some_facets(random, problem.start_m, random.below(2) == 0 ? 0.0 : 0.001, 1 + random.below(8));
    problem.probe_m = problem.start_m + random.in_cube(0.004);
    const Vec3 way_m = way_out_by_all_faces(facets, problem.probe_m);
    const double depth_m = norm(way_m);
    // At the yield itself, and about it.
    const double share = i % 3 == 0 ? 1.0 : random.uniform(0.3, 3.0);
    const double strength_n = std::max(1e-6, share * problem.stiffness_n_per_m * depth_m);
    add_corner(problem, facets, strength_n);
    const Solved result = solved(problem);
    const double gone_m = std::min(depth_m, strength_n / problem.stiffness_n_per_m);
    const Vec3 expected_m = problem.probe_m + (depth_m > 0.0 ? gone_m / depth_m : 0.0) * way_m;
    EXPECT_LE(distance(result.balance.position_m, expected_m), 1e-9) << i;
    EXPECT_LE(distance(result.balance.position_m, expected_m), result.balance.error_bound_m + 1e-13) << i;
  }
}

TEST(Corner, OfAGrooveHoldsTheHandPressedStraightInUntilItsStrength) {
  for (const double opening_rad : {0.02, 0.3, 1.0, 2.0, 3.0}) {
    const double s = 1.2, k = 400.0;
    Problem problem;
    problem.stiffness_n_per_m = k;
    const double half = 0.5 * opening_rad;
    add_corner(problem, {{{}, {std::cos(half), 0, std::sin(half)}}, {{}, {-std::cos(half), 0, std::sin(half)}}}, s);
    for (const double depth_m : {0.0, 0.001, 0.003, 0.0030001, 0.008}) {
      problem.probe_m = {0, 0.002, -depth_m};
      const Vec3 expected_m{0, 0.002, -std::max(0.0, depth_m - s / k)};
      EXPECT_LE(distance(solved(problem).balance.position_m, expected_m), 1e-9) << opening_rad << ", " << depth_m;
    }
  }
}

Problem some_problem(Random& random) {
  Problem problem = random_problem(random, random.below(4), random.below(3) == 0);
  const int corners = 1 + random.below(2);
  for (int i = 0; i < corners; ++i) {
    const double within_m = random.below(2) == 0 ? 0.0 : 0.001;
    add_corner(problem, some_facets(random, problem.start_m, within_m, 1 + random.below(8)), random.uniform(0.1, 5.0));
  }
  return problem;
}

TEST(Corner, ItsForcesAreThoseOfAtMostThreeFacetsWhichAloneGiveTheSameBalance) {
  Random random(3);
  for (int i = 0; i < 3000; ++i) {
    const Problem problem = some_problem(random);
    const Solved all = solved(problem);
    Problem recorded = problem;
    recorded.primitives.clear();
    for (std::size_t j = 0; j < problem.primitives.size();) {
      const std::span<const Primitive> whole = whole_of(problem.primitives, j);
      int pressed = 0;
      Vec3 sum_n;
      for (const Primitive& p : whole) {
        const Vec3& force_n = all.forces_n[j++];
        const bool is_facet = p.kind == PrimitiveKind::corner;
        if (is_facet) {
          EXPECT_LE(norm(cross(force_n, p.direction)), 1e-14 * (1.0 + norm(force_n)));
          EXPECT_GE(dot(force_n, p.direction), 0.0);
        }
        sum_n += force_n;
        pressed += norm(force_n) > 0.0;
        if (!is_facet || norm(force_n) > 0.0) recorded.primitives.push_back(p);
      }
      if (whole[0].kind != PrimitiveKind::corner) continue;
      EXPECT_LE(pressed, 3);
      EXPECT_LE(norm(sum_n), whole[0].strength_n * (1.0 + 1e-12));
    }
    const Balance again = solved(recorded).balance;
    EXPECT_LE(distance(again.position_m, all.balance.position_m), again.error_bound_m + all.balance.error_bound_m) << i;
  }
}

TEST(Corner, OfOneFacetIsAPlane) {
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    Problem problem = random_problem(random, 1 + random.below(5), false);
    Problem corners = problem;
    for (Primitive& p : corners.primitives) p.kind = p.kind == PrimitiveKind::plane ? PrimitiveKind::corner : p.kind;
    const Solved a = solved(problem), b = solved(corners);
    EXPECT_EQ(a.balance.position_m, b.balance.position_m);
    EXPECT_EQ(a.forces_n, b.forces_n);
    // Likewise by the solution of a larger corner: with a facet twice, and one that is never reached.
    Problem redundant = problem;
    redundant.primitives.clear();
    for (const Primitive& p : corners.primitives) {
      redundant.primitives.push_back(p);
      if (p.kind != PrimitiveKind::corner) continue;
      redundant.primitives.push_back(p);
      redundant.primitives.push_back(p);
      redundant.primitives.back().position_m -= 0.01 * p.direction;
    }
    const Balance c = solved(redundant).balance;
    EXPECT_LE(distance(a.balance.position_m, c.position_m), a.balance.error_bound_m + c.error_bound_m) << i;
  }
}

TEST(Corner, FacetsThatEnterMoveTheBalanceByNoMoreThanTheyCutItOff) {
  Random random(5);
  for (int i = 0; i < 3000; ++i) {
    Problem before = random_problem(random, random.below(4), false);
    Facets facets = some_facets(random, before.start_m, 0.001, 2 + random.below(6));
    const double s = random.uniform(0.1, 5.0);
    Problem after = before;
    add_corner(after, facets, s);
    facets.pop_back();
    add_corner(before, facets, s);
    const Balance x = solved(before).balance, y = solved(after).balance;
    const auto reach_m = [&](const Problem& problem, const Vec3& at_m) {
      return norm(residual(problem.primitives, problem.primitives.size() - 1, at_m));
    };
    // k|x' − x|² ≤ s (dist(x, P') − dist(x, P)), with x and x' within their bounds.
    const double off_m = x.error_bound_m + y.error_bound_m;
    const double cut_m = reach_m(after, x.position_m) - reach_m(before, x.position_m) + 2.0 * off_m;
    EXPECT_LE(distance(x.position_m, y.position_m), std::sqrt(s * std::max(0.0, cut_m) / before.stiffness_n_per_m) + off_m)
        << i;
  }
}

// Invented facets, moved back to a point w where they would exclude it, cause no break-through while the demand at w is below
// the strength, and inject no energy.
TEST(Corner, OfWrongFacetsPutBackToAFreePlaceNeverBreaksThroughBelowItsStrength) {
  Random random(6);
  for (int i = 0; i < 5000; ++i) {
    Problem problem;
    const Vec3 w_m = random.in_cube(0.05);
    problem.start_m = w_m;
    problem.stiffness_n_per_m = random.uniform(100, 3000);
    problem.probe_m = w_m + random.in_cube(0.004);
    Facets facets = some_facets(random, w_m, 0.01, 1 + random.below(8));
    for (Facet& f : facets) f.position_m -= std::max(0.0, dot(f.normal, f.position_m - w_m)) * f.normal;
    const double demand_n = problem.stiffness_n_per_m * distance(problem.probe_m, w_m);
    const double strength_n = demand_n * random.uniform(1.0, 3.0);
    add_corner(problem, facets, strength_n);
    const Solved result = solved(problem);
    const Vec3& x_m = result.balance.position_m;
    EXPECT_LE(norm(residual(problem.primitives, 0, x_m)), result.balance.error_bound_m + 1e-14) << i;
    Vec3 force_n;
    for (const Vec3& one : result.forces_n) force_n += one;
    EXPECT_LE(norm(force_n), demand_n * (1.0 + 1e-9) + 1e-9);
    const double before_j = 0.5 * problem.stiffness_n_per_m * norm_squared(w_m - problem.probe_m);
    const double after_j = 0.5 * problem.stiffness_n_per_m * norm_squared(x_m - problem.probe_m);
    EXPECT_LE(after_j + 0.5 * problem.stiffness_n_per_m * norm_squared(x_m - w_m),
              before_j + problem.stiffness_n_per_m * 0.01 * result.balance.error_bound_m + 1e-15);
  }
}

TEST(Corner, BoundHoldsForAnyPlaceAndAnyForces) {
  Random random(7);
  for (int i = 0; i < 5000; ++i) {
    const Problem problem = some_problem(random);
    const Solved truth = solved(problem);
    PrimitiveSet set(64);
    fill(set, problem);
    const double far_m = std::exp(random.uniform(-20, -5));
    const Vec3 x_m = truth.balance.position_m + random.in_cube(far_m);
    std::vector<Vec3> forces_n = truth.forces_n;
    const double off_n = std::exp(random.uniform(-30, 2));
    for (Vec3& force_n : forces_n) force_n += off_n * random.in_cube(1.0);
    const auto bound_m = [&](const std::vector<Vec3>& forces) {
      return error_bound_m(set.primitives(), forces, x_m, problem.probe_m, problem.stiffness_n_per_m, problem.time_step_s);
    };
    const double error_m = distance(x_m, truth.balance.position_m) - truth.balance.error_bound_m;
    EXPECT_GE(bound_m(forces_n), error_m) << i;
    EXPECT_GE(bound_m(truth.forces_n), error_m) << i;
    EXPECT_GE(bound_m(std::vector<Vec3>(forces_n.size())), error_m) << i;
  }
}

TEST(Corner, IsOffStuckOrSlippingAsAWhole) {
  Problem problem;
  add_corner(problem, {{{}, {1, 0, 0}}, {{}, {0, 1, 0}}}, 1.0);
  const auto state = [&](const Vec3& x_m, std::size_t i) {
    return state_at(problem.primitives, i, Balance{x_m, 1e-9, BalanceStatus::exact, 1, 1});
  };
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_EQ(state({0.001, 0.001, 0}, i), PrimitiveState::off);
    EXPECT_EQ(state({0.001, 0, 0}, i), PrimitiveState::stick);
    EXPECT_EQ(state({0, 0, 0.5}, i), PrimitiveState::stick);
    EXPECT_EQ(state({0.001, -0.001, 0}, i), PrimitiveState::slip);
    EXPECT_EQ(state({-0.001, -0.001, 0}, i), PrimitiveState::slip);
  }
}

// The line along the newest facet's normal acts as beside a plane, in closed form.
TEST(Corner, ItsFacetsPressTogetherInOneDirection) {
  Random random(13);
  for (int i = 0; i < 2000; ++i) {
    Problem problem;
    add_corner(problem, some_facets(random, {}, 0.0, 1 + random.below(8)), 1.0);
    std::vector<Vec3> forces_n(problem.primitives.size());
    EXPECT_EQ(pressed_direction(problem.primitives, forces_n), Vec3{});
    const std::size_t alone = static_cast<std::size_t>(random.below(static_cast<int>(forces_n.size())));
    forces_n[alone] = random.uniform(1e-6, 1.0) * problem.primitives[alone].direction;
    EXPECT_EQ(pressed_direction(problem.primitives, forces_n), problem.primitives[alone].direction);
    Vec3 sum_n;
    for (std::size_t j = 0; j < forces_n.size(); ++j)
      sum_n += forces_n[j] = random.uniform(0.1, 1.0) * problem.primitives[j].direction;
    const Vec3 together = pressed_direction(problem.primitives, forces_n);
    EXPECT_NEAR(norm(together), 1.0, 1e-15);
    EXPECT_LE(distance(norm(sum_n) * together, sum_n), 1e-14);
  }
  const Primitive facing[] = {{PrimitiveKind::corner, {}, {}, {0, 0, 1}, 1.0},
                              {PrimitiveKind::corner, {}, {}, {0, 0, -1}, 1.0}};
  const Vec3 cancelling_n[] = {{0, 0, 0.5}, {0, 0, -0.5}};
  EXPECT_EQ(pressed_direction(facing, cancelling_n), Vec3{});
}

TEST(Corner, WithFrictionWhereOneFacetHoldsIsAPlaneWithFriction) {
  Random random(8);
  for (int i = 0; i < 2000; ++i) {
    Problem problem;
    problem.start_m = random.in_cube(0.05);
    problem.probe_m = problem.start_m + random.in_cube(0.003);
    const Vec3 n = random.direction();
    const double s = random.uniform(0.1, 5.0), rubbed_n = random.uniform(0.0, 1.0);
    Problem plane = problem;
    plane.primitives = {{PrimitiveKind::plane, {0, 0}, problem.start_m, n, s, 0.0}};
    Facets facets = some_facets(random, problem.start_m, 0.0, 3);
    for (Facet& f : facets) f.normal = normalized(f.normal + 1.5 * n), f.position_m -= 0.03 * f.normal;
    facets.push_back({problem.start_m, n});
    add_corner(problem, facets, s);
    const Primitive friction{PrimitiveKind::line, {0, 9}, problem.start_m, n, rubbed_n, 0.0};
    problem.primitives.push_back(friction);
    plane.primitives.push_back(friction);
    const Solved a = solved(plane), b = solved(problem);
    EXPECT_EQ(b.balance.stage, 1);
    EXPECT_LE(b.balance.error_bound_m, 1e-15);
    EXPECT_LE(distance(a.balance.position_m, b.balance.position_m), a.balance.error_bound_m + b.balance.error_bound_m);
  }
}

TEST(Corner, SetsTakeFacetsOneByOneAndKeepTheHandles) {
  PrimitiveSet set(12);
  set.clear({});
  set.plane(0, {}, {0, 0, 1}, 1.0, {3, 0.5});
  set.plane(1, {}, {1, 0, 0}, 2.0);
  set.friction(2, 1, {}, 0.4);
  EXPECT_TRUE(set.add_facet(0, {0.001, 0, 0}, normalized(Vec3{1, 0, 1})));
  EXPECT_TRUE(set.add_facet(0, {0.002, 0, 0}, normalized(Vec3{0, 1, 1})));
  ASSERT_EQ(set.size(), 5u);
  EXPECT_EQ(set.dropped(), 0);
  EXPECT_EQ(set[0].kind, PrimitiveKind::corner);
  EXPECT_EQ(set[1].position_m.x, 0.001);
  EXPECT_EQ(set[2].position_m.x, 0.002);
  EXPECT_EQ(whole_of(set.primitives(), 1).data(), &set[0]);
  EXPECT_EQ(whole_of(set.primitives(), 1).size(), 3u);
  EXPECT_EQ(whole_of(set.primitives(), 3).size(), 1u);
  EXPECT_EQ(set.captured(2), (HeldLevel{3, 0.5}));
  EXPECT_EQ(set.friction_of(4).plane, 1);  // a handle, while its row has moved
  const auto rows = [&] { return std::array{set.row(0), set.row(1), set.row(2)}; };
  EXPECT_EQ(rows(), (std::array<std::size_t, 3>{0, 3, 4}));
  EXPECT_FALSE(set.friction_of(2).any());

  const auto refused_as = [&](Refusal reason, bool taken) {
    EXPECT_FALSE(taken);
    ASSERT_FALSE(set.refused().empty());
    EXPECT_EQ(set.refused().back().reason, reason) << sentence_of(set.refused().back().reason);
  };
  refused_as(Refusal::corner_too_narrow, set.add_facet(0, {}, {0, 0, -1}));
  refused_as(Refusal::facet_without_plane, set.add_facet(2, {}, {0, 0, 1}));
  refused_as(Refusal::direction_not_unit, set.add_facet(0, {}, {0, 0, 2}));
  refused_as(Refusal::position_not_finite, set.add_facet(0, {NAN, 0, 0}, {0, 0, 1}));
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(set.add_facet(0, {}, {0, 0, 1}));
  refused_as(Refusal::facets_full, set.add_facet(0, {}, {0, 0, 1}));
  EXPECT_TRUE(set.add_facet(1, {}, {0, 1, 0}));
  EXPECT_TRUE(set.add_facet(1, {}, {0, 1, 0}));
  ASSERT_EQ(set.size(), 12u);
  refused_as(Refusal::full, set.add_facet(1, {}, {0, 1, 0}));
  set.remove_facet(9);
  set.remove_facet(1);
  EXPECT_EQ(rows(), (std::array<std::size_t, 3>{0, 7, 9}));
  set.friction(3, 1, {}, 0.2);
  EXPECT_EQ(set.friction_of(set.row(3)).plane, 1);
  EXPECT_EQ(set[set.row(3)].direction, (Vec3{1, 0, 0}));

  set.clear({});
  set.plane(0, {}, {0, 0, 1}, 1.0, {}, 2.0);
  refused_as(Refusal::facet_with_drag, set.add_facet(0, {}, {0, 0, 1}));
}

TEST(Corner, WidthIsTheSineOfHalfTheOpeningOfAGroove) {
  for (const double opening_rad : {0.001, 0.01, 0.5, 1.5, 3.0}) {
    const double half = 0.5 * opening_rad;
    const Vec3 normals[] = {{std::cos(half), std::sin(half), 0}, {-std::cos(half), std::sin(half), 0}};
    EXPECT_NEAR(detail::width_of(normals), std::sin(half), 1e-12);
  }
  const Vec3 facing[] = {{1, 0, 0}, {-1, 0, 0}};
  EXPECT_EQ(detail::width_of(facing), 0.0);
  const Vec3 around[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, normalized(Vec3{-1, -1, -1})};
  EXPECT_EQ(detail::width_of(around), 0.0);
}

}  // namespace corner_test
}  // namespace palpa::test
