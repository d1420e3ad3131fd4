// Relations between the balances of two problems, without a reference, to the sum of the returned bounds and the rounding of
// the change itself.
#include <gtest/gtest.h>

#include <array>

#include "palpa/solver/corner.h"
#include "tests/solver/solved.h"

namespace palpa::test {
namespace metamorphic_test {

constexpr double half_ulp = 0x1p-53;

// Units of the law: a primitive, or all facets of a corner.
using Wholes = std::vector<std::vector<Primitive>>;
Wholes wholes_of(const Problem& problem) {
  Wholes wholes;
  for (std::size_t i = 0; i < problem.primitives.size(); i += wholes.back().size()) {
    const std::span<const Primitive> whole = whole_of(problem.primitives, i);
    wholes.emplace_back(whole.begin(), whole.end());
  }
  return wholes;
}
void put(Problem& problem, const Wholes& wholes) {
  problem.primitives.clear();
  for (std::size_t i = 0; i < wholes.size(); ++i) {
    for (Primitive p : wholes[i]) {
      p.id.slot = static_cast<std::uint16_t>(i);
      problem.primitives.push_back(p);
    }
  }
}

template <class Value>
void shuffle(std::vector<Value>& values, Random& random) {
  for (std::size_t i = values.size(); i-- > 1;)
    std::swap(values[i], values[static_cast<std::size_t>(random.below(static_cast<int>(i) + 1))]);
}

double drag_n_per_m(const Problem& problem, const Primitive& p) {
  return p.drag_ns_per_m > 0.0 ? p.drag_ns_per_m / problem.time_step_s : 0.0;
}

double width_of(std::span<const Primitive> whole) {
  if (whole.size() == 1) return 1.0;
  std::vector<Vec3> normals;
  for (const Primitive& facet : whole) normals.push_back(facet.direction);
  return detail::width_of(normals);
}

// Largest move of the balance [m] when the residual of every primitive changes by up to `change_m(p)`: E then changes by (s +
// C(|r| + δ))δ each, a corner's by s δ/σ with σ its width. Both balances are minimisers of a function of convexity k, so k|Δx|²
// is at most the sum of those changes at the two.
template <class Change>
double moved_by_m(const Problem& problem, const Vec3& x1_m, const Vec3& x2_m, Change change_m) {
  double change_j = 0.0;
  for (std::size_t i = 0; i < problem.primitives.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    const double delta_m = change_m(p) / width_of(whole_of(problem.primitives, i));
    const double reach_m = norm(residual(p, x1_m)) + norm(residual(p, x2_m)) + delta_m;
    change_j += (2.0 * p.strength_n + drag_n_per_m(problem, p) * reach_m) * delta_m;
  }
  return std::sqrt(change_j / problem.stiffness_n_per_m);
}

// Every law over every family, with and without drags.
template <class Check>
void over_problems(Check check) {
  for (const Family& family : families()) {
    for (const bool drags : {false, true}) {
      for_each_problem(family, drags, {1, 2, 3, 5, 8, 16, 64}, 4, [&](const Recipe& recipe) {
        const Problem problem = recipe.problem();
        Random random(recipe.seed + 7);
        SCOPED_TRACE(testing::Message() << recipe);
        check(problem, random);
      });
    }
  }
}

void expect_same(const Balance& a, const Balance& b, double rounding_m = 0.0) {
  const double apart_m = distance(a.position_m, b.position_m);
  EXPECT_LE(apart_m, (a.error_bound_m + b.error_bound_m + rounding_m) * (1 + 1e-12))
      << "bounds " << a.error_bound_m << " and " << b.error_bound_m << ", rounding " << rounding_m;
}

TEST(Metamorphic, OrderDoesNotMatter) {
  over_problems([&](const Problem& problem, Random& random) {
    Problem permuted = problem;
    Wholes wholes = wholes_of(problem);
    for (std::vector<Primitive>& whole : wholes) shuffle(whole, random);
    shuffle(wholes, random);
    put(permuted, wholes);
    expect_same(solved(problem).balance, solved(permuted).balance);
  });
}

TEST(Metamorphic, PartsOfAPrimitiveAreThePrimitive) {
  over_problems([&](const Problem& problem, Random& random) {
    Problem split = problem;
    Wholes parts;
    for (const std::vector<Primitive>& whole : wholes_of(problem)) {
      const bool three = random.below(2) == 0;
      for (const double share : three ? std::vector{0.5, 0.25, 0.25} : std::vector{0.5, 0.5}) {  // without rounding
        parts.push_back(whole);
        for (Primitive& p : parts.back()) p.strength_n *= share, p.drag_ns_per_m *= share, p.stiffness_n_per_m *= share;
      }
    }
    put(split, parts);
    expect_same(solved(problem).balance, solved(split).balance);
  });
}

TEST(Metamorphic, TheScaleOfAllForcesDoesNotMatter) {
  over_problems([&](const Problem& problem, Random& random) {
    const Balance balance = solved(problem).balance;
    for (const double factor : {0.25, 8.0, random.uniform(0.3, 3.0)}) {
      Problem scaled = problem;
      scaled.stiffness_n_per_m *= factor;
      double forces_n = problem.stiffness_n_per_m * distance(balance.position_m, problem.probe_m);
      for (Primitive& p : scaled.primitives) {
        forces_n += p.strength_n + drag_n_per_m(problem, p) * norm(residual(p, balance.position_m));
        p.strength_n *= factor;
        p.drag_ns_per_m *= factor;
        p.stiffness_n_per_m *= factor;
      }
      // Each of k, s and c is rounded once; the added force moves the balance by a k-th of it.
      const double rounding_m = 2.0 * half_ulp * forces_n / problem.stiffness_n_per_m;
      expect_same(balance, solved(scaled).balance, rounding_m);
    }
  });
}

TEST(Metamorphic, WhereOnALineOrPlaneItsAnchorIsDoesNotMatter) {
  over_problems([&](const Problem& problem, Random& random) {
    Problem slid = problem;
    constexpr double far_m = 0.01;
    for (Primitive& p : slid.primitives) {
      const double slide_m = random.uniform(-far_m, far_m);
      if (p.kind == PrimitiveKind::line) p.position_m += slide_m * p.direction;
      if (p.kind == PrimitiveKind::plane || p.kind == PrimitiveKind::corner)
        p.position_m += slide_m * normalized(cross(p.direction, random.direction()));
    }
    const Balance a = solved(problem).balance;
    const Balance b = solved(slid).balance;
    // The new anchor is rounded, and the direction to slide in is across the normal, or along the line, to some ulp of the unit
    // length.
    expect_same(a, b, moved_by_m(problem, a.position_m, b.position_m, [&](const Primitive& p) {
                  return p.kind == PrimitiveKind::point ? 0.0 : 4.0 * half_ulp * (norm(p.position_m) + 2.0 * far_m);
                }));
  });
}

TEST(Metamorphic, TheSenseOfALineDoesNotMatter) {
  over_problems([&](const Problem& problem, Random& random) {
    Problem flipped = problem;
    for (Primitive& p : flipped.primitives) {
      if (p.kind == PrimitiveKind::line && random.below(3) != 0) p.direction = -p.direction;
    }
    expect_same(solved(problem).balance, solved(flipped).balance);
  });
}

TEST(Metamorphic, AChangeOfStrengthMovesByNoMoreThanItOverTheStiffness) {
  over_problems([&](const Problem& problem, Random& random) {
    Problem changed = problem;
    Wholes wholes = wholes_of(problem);
    const bool one = random.below(2) == 0;
    const std::size_t which = static_cast<std::size_t>(random.below(static_cast<int>(wholes.size())));
    double change_n = 0.0;
    for (std::size_t i = 0; i < wholes.size(); ++i) {
      if (one && i != which) continue;
      const double before = wholes[i][0].strength_n;
      const double s = std::max(0.0, before + std::exp(random.uniform(-25, 0)) * (random.below(2) == 0 ? 1.0 : -1.0));
      for (Primitive& p : wholes[i]) p.strength_n = s;
      change_n += std::abs(s - before);
    }
    put(changed, wholes);
    expect_same(solved(problem).balance, solved(changed).balance, change_n / problem.stiffness_n_per_m);
  });
}

// |Δx|² ≤ Δx·Δp of the exact balances; each of the two positions is off by its bound at most.
TEST(Metamorphic, IsFirmlyNonExpansive) {
  over_problems([&](const Problem& problem, Random& random) {
    const Balance first = solved(problem).balance;
    for (const double far_m : {0.01, 1e-5}) {
      Problem moved = problem;
      moved.probe_m += random.in_cube(far_m);
      const Balance second = solved(moved).balance;
      const Vec3 dx = second.position_m - first.position_m;
      const Vec3 dp = moved.probe_m - problem.probe_m;
      const double off = first.error_bound_m + second.error_bound_m;
      const double slack = off * (2.0 * (norm(dx) + off) + off + norm(dp));
      const double rounding = 16.0 * half_ulp * (norm_squared(dx) + norm(dx) * norm(dp));
      EXPECT_LE(norm_squared(dx), dot(dx, dp) + slack + rounding);
    }
  });
}

// Turns by a quarter and mirrors have no rounding.
TEST(Metamorphic, TurnsWithItsAxes) {
  over_problems([&](const Problem& problem, Random& random) {
    const std::array<double, 3> sign{random.below(2) ? 1.0 : -1.0, random.below(2) ? 1.0 : -1.0, random.below(2) ? 1.0 : -1.0};
    const auto turned = [&](const Vec3& a) { return Vec3{sign[0] * a.y, sign[1] * a.z, sign[2] * a.x}; };
    Problem other = problem;
    other.start_m = turned(problem.start_m);
    other.probe_m = turned(problem.probe_m);
    for (Primitive& p : other.primitives) p.position_m = turned(p.position_m), p.direction = turned(p.direction);
    Balance balance = solved(problem).balance;
    balance.position_m = turned(balance.position_m);
    expect_same(balance, solved(other).balance);
  });
}

TEST(Metamorphic, MovesWithTheWorld) {
  over_problems([&](const Problem& problem, Random& random) {
    const Mat3 rotation = random.rotation();
    const Vec3 shift_m = random.in_cube(0.02);
    const auto moved = [&](const Vec3& x_m) { return rotation * x_m + shift_m; };
    // Three products and three sums, and a matrix that is a rotation to some ulp.
    const auto rounding_of = [&](const Vec3& x_m) { return 16.0 * half_ulp * (norm(x_m) + norm(shift_m)); };
    Problem other = problem;
    other.start_m = moved(problem.start_m);
    other.probe_m = moved(problem.probe_m);
    for (Primitive& p : other.primitives) {
      p.position_m = moved(p.position_m);
      p.direction = normalized(rotation * p.direction);
    }
    Balance a = solved(problem).balance;
    const Balance b = solved(other).balance;
    const Vec3 x1_m = a.position_m;
    a.position_m = moved(x1_m);
    const Vec3 x2_m = transposed_times(rotation, b.position_m - shift_m);
    double directed_n = 0.0;
    for (const Primitive& p : problem.primitives) directed_n += p.kind == PrimitiveKind::directed ? p.strength_n : 0.0;
    const double turned = 16.0 * half_ulp;
    const double rounding_m =
        rounding_of(x1_m) + rounding_of(problem.probe_m) + turned * directed_n / problem.stiffness_n_per_m +
        moved_by_m(problem, x1_m, x2_m, [&](const Primitive& p) {
          return rounding_of(p.position_m) + rounding_of(x1_m) + 2.0 * turned * distance(p.position_m, x1_m);
        });
    expect_same(a, b, rounding_m);
  });
}

// With all anchors at one point a and no drag or elasticity: x of all is x of all but the points, drawn towards a by the
// points' strengths over k.
TEST(Metamorphic, PointsAtTheCommonAnchorCompose) {
  over_problems([&](const Problem& problem, Random& random) {
    Problem all = problem;
    for (Primitive& p : all.primitives) {
      p.drag_ns_per_m = 0.0;
      p.stiffness_n_per_m = std::numeric_limits<double>::infinity();
      if (p.kind != PrimitiveKind::directed) p.position_m = problem.start_m;
      const bool turns = p.kind != PrimitiveKind::directed && p.kind != PrimitiveKind::corner;
      if (random.below(4) == 0 && turns) p.kind = PrimitiveKind::point, p.direction = {};
    }
    Problem rest = all;
    std::erase_if(rest.primitives, [](const Primitive& p) { return p.kind == PrimitiveKind::point; });
    put(rest, wholes_of(rest));
    double points_n = 0.0;
    for (const Primitive& p : all.primitives) points_n += p.kind == PrimitiveKind::point ? p.strength_n : 0.0;

    Balance expected = solved(rest).balance;
    const Vec3 off_m = expected.position_m - problem.start_m;
    const double length_m = norm(off_m);
    const double left_m = std::max(0.0, length_m - points_n / problem.stiffness_n_per_m);
    if (length_m > 0.0) expected.position_m = problem.start_m + (left_m / length_m) * off_m;
    const double rounding_m =
        4.0 * half_ulp * (norm(problem.start_m) + length_m) + 70.0 * half_ulp * points_n / problem.stiffness_n_per_m;
    expect_same(expected, solved(all).balance, rounding_m);
  });
}

TEST(Metamorphic, AWarmStartChangesNothing) {
  over_problems([&](const Problem& made, Random& random) {
    Problem problem = made;
    const std::size_t capacity = problem.primitives.size();
    Solver solver(capacity);
    PrimitiveSet set(capacity);
    for (int tick = 0; tick < 6; ++tick) {
      expect_same(solved(problem, solver, set).balance, solved(problem).balance);
      problem.probe_m += random.in_cube(tick % 2 == 0 ? 1e-6 : 5e-4);
      if (tick == 3) std::reverse(problem.primitives.begin(), problem.primitives.end());
    }
  });
}

}  // namespace metamorphic_test
}  // namespace palpa::test
