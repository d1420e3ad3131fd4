// The least split: forces of the modes where several can hold.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <limits>
#include <numeric>

#include "palpa/solver/split.h"
#include "tests/solver/counted_allocations.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace split_test {

using test::Random;

// Primitives that all stick at one point, with one valid split of force over them.
struct Stuck {
  std::vector<Primitive> primitives;
  std::vector<Vec3> forces_n;
  Balance balance{.error_bound_m = 1e-10};

  void add(PrimitiveKind kind, const Vec3& direction, double strength_n, const Vec3& force_n, double drag_ns_per_m = 0.0) {
    const auto slot = static_cast<std::uint16_t>(primitives.size());
    primitives.push_back({kind, {0, slot}, balance.position_m, direction, strength_n, drag_ns_per_m});
    forces_n.push_back(force_n);
  }
  double split() { return least_split(primitives, balance, forces_n); }
};

Vec3 total_n(const std::vector<Vec3>& forces_n) { return std::accumulate(forces_n.begin(), forces_n.end(), Vec3{}); }

double strengths_n(const Stuck& stuck) {
  double all = 0.0;
  for (const Primitive& p : stuck.primitives) all += p.strength_n;
  return all;
}

// The point of a primitive's force set next to `force`.
Vec3 allowed(const Primitive& p, const Vec3& force_n) {
  const Vec3& q = p.direction;
  if (p.kind == PrimitiveKind::point) return shortened(force_n, p.strength_n);
  if (p.kind == PrimitiveKind::line) return shortened(force_n - dot(q, force_n) * q, p.strength_n);
  return std::clamp(dot(q, force_n), 0.0, p.strength_n) * q;
}

// Σ|u|²/s [N]; strengths of zero have no force.
double cost(const Stuck& stuck, const std::vector<Vec3>& forces_n) {
  double sum = 0.0;
  for (std::size_t i = 0; i < forces_n.size(); ++i) {
    if (stuck.primitives[i].strength_n > 0.0) sum += norm_squared(forces_n[i]) / stuck.primitives[i].strength_n;
  }
  return sum;
}

enum class Shape { any, parallel, nearly_parallel, wide_strengths, at_limits, planes };
constexpr Shape shapes[] = {Shape::any,       Shape::parallel, Shape::nearly_parallel, Shape::wide_strengths,
                            Shape::at_limits, Shape::planes};

Stuck random_stuck(Random& random, int n, Shape shape) {
  Stuck stuck;
  stuck.balance.position_m = random.in_cube(0.1);
  const Vec3 main = random.direction();
  const double angle = std::pow(10.0, random.uniform(-9.0, -2.0));
  for (int i = 0; i < n; ++i) {
    const auto kind = shape == Shape::planes ? PrimitiveKind::plane : static_cast<PrimitiveKind>(random.below(3));
    Vec3 q = random.direction();
    if (shape == Shape::parallel) q = random.below(2) ? main : -main;
    if (shape == Shape::nearly_parallel) q = normalized((random.below(4) ? main : -main) + angle * random.direction());
    double s = random.below(8) == 0 ? 0.0 : random.uniform(0.01, 5.0);
    if (shape == Shape::wide_strengths) s = std::pow(10.0, random.uniform(-6.0, 3.0));
    const Vec3 wanted = shape == Shape::at_limits ? 10.0 * s * main : s * random.in_cube(1.5);
    stuck.add(kind, q, s, {});
    stuck.forces_n.back() = allowed(stuck.primitives.back(), wanted);
  }
  return stuck;
}

TEST(LeastSplit, KeepsTheTotalWithinWhatEachCanExert) {
  Random random(1);
  for (const Shape shape : shapes) {
    double worst = 0.0;
    for (int i = 0; i < 4000; ++i) {
      Stuck stuck = random_stuck(random, 1 + random.below(i % 50 == 0 ? 200 : 16), shape);
      const std::vector<Vec3> given = stuck.forces_n;
      const double left_n = stuck.split();
      const double scale_n = norm(total_n(given)) + strengths_n(stuck);
      const double missed_n = distance(total_n(stuck.forces_n), total_n(given));
      ASSERT_NEAR(missed_n, left_n, 1e-13 * scale_n);
      ASSERT_LE(missed_n, 1e-12 * scale_n) << i;
      worst = std::max(worst, missed_n / (scale_n > 0.0 ? scale_n : 1.0));
      for (std::size_t j = 0; j < given.size(); ++j) {
        ASSERT_LE(distance(stuck.forces_n[j], allowed(stuck.primitives[j], stuck.forces_n[j])),
                  1e-14 * stuck.primitives[j].strength_n);
      }
    }
    std::printf("shape %d: total kept to %.2g of forces and strengths\n", static_cast<int>(shape), worst);
  }
}

// With C(u) = ½ Σ|u|²/s convex, u is least exactly if no valid split v lies downhill: Σ (u/s)·(v − u) ≥ 0.
TEST(LeastSplit, LeavesNoOtherSplitDownhill) {
  Random random(2);
  for (const Shape shape : shapes) {
    // With directions 1e-9 rad apart, a total kept to rounding determines the split no better.
    const double tolerance = shape == Shape::nearly_parallel ? 1e-5 : 1e-12;
    int cheaper = 0;
    double worst = 0.0;
    for (int i = 0; i < 4000; ++i) {
      Stuck stuck = random_stuck(random, 2 + random.below(10), shape);
      const std::vector<Vec3> other = stuck.forces_n;
      stuck.split();
      double downhill = 0.0;
      for (std::size_t j = 0; j < other.size(); ++j) {
        if (stuck.primitives[j].strength_n > 0.0) {
          downhill -= dot(stuck.forces_n[j], other[j] - stuck.forces_n[j]) / stuck.primitives[j].strength_n;
        }
      }
      ASSERT_LE(downhill, tolerance * strengths_n(stuck)) << static_cast<int>(shape) << " " << i;
      worst = std::max(worst, downhill / std::max(1e-300, strengths_n(stuck)));
      cheaper += cost(stuck, stuck.forces_n) < 0.999 * cost(stuck, other);
    }
    std::printf("shape %d: downhill at most %.2g of the strengths\n", static_cast<int>(shape), worst);
    // With all at their limits there is one split only.
    EXPECT_GT(cheaper, shape == Shape::at_limits ? -1 : 100) << "so few splits could be improved that this says nothing";
  }
}

// The least split is nearest to zero in both the splits of the total and the force sets, by the metric Σ|u|²/s: Dykstra's
// alternating projections find it without multipliers.
TEST(LeastSplit, IsWhatAlternatingProjectionsFind) {
  Random random(3);
  double worst_n = 0.0;
  int found = 0;
  for (int i = 0; i < 100; ++i) {
    Stuck stuck = random_stuck(random, 2 + random.below(6), i % 2 ? Shape::any : Shape::planes);
    std::erase_if(stuck.primitives, [](const Primitive& p) { return p.strength_n == 0.0; });
    stuck.forces_n.resize(stuck.primitives.size());
    for (std::size_t j = 0; j < stuck.forces_n.size(); ++j) {
      stuck.forces_n[j] = allowed(stuck.primitives[j], stuck.primitives[j].strength_n * random.in_cube(0.8));
    }
    const Vec3 wanted_n = total_n(stuck.forces_n);
    const std::size_t n = stuck.forces_n.size();
    std::vector<Vec3> u(n), correction(n);
    for (int round = 0; round < 10000; ++round) {
      const Vec3 missing_n = wanted_n - total_n(u);
      for (std::size_t j = 0; j < n; ++j) {
        u[j] += (stuck.primitives[j].strength_n / strengths_n(stuck)) * missing_n;  // next split of the total
        const Vec3 before = u[j] + correction[j];
        u[j] = allowed(stuck.primitives[j], before);
        correction[j] = before - u[j];
      }
    }
    if (distance(total_n(u), wanted_n) > 1e-9) continue;  // these projections can be slow
    ++found;
    stuck.split();
    for (std::size_t j = 0; j < n; ++j) {
      worst_n = std::max(worst_n, distance(u[j], stuck.forces_n[j]));
      ASSERT_LE(distance(u[j], stuck.forces_n[j]), 1e-5) << i;
    }
  }
  std::printf("%d found by alternating projections, at most %.2g N apart\n", found, worst_n);
  EXPECT_GT(found, 50);
}

TEST(LeastSplit, DependsOnNoOrderNorOnTheSplitThatWasGiven) {
  Random random(4);
  for (int i = 0; i < 3000; ++i) {
    Stuck stuck = random_stuck(random, 2 + random.below(12), i % 2 ? Shape::any : Shape::parallel);
    Stuck other = stuck;
    for (std::size_t j = stuck.primitives.size(); j-- > 1;) {
      const auto k = static_cast<std::size_t>(random.below(static_cast<int>(j) + 1));
      std::swap(other.primitives[j], other.primitives[k]);
      std::swap(other.forces_n[j], other.forces_n[k]);
    }
    stuck.split();
    other.split();
    Stuck third = stuck;  // from another split of an equal total
    const double tolerance_n = 1e-12 * strengths_n(stuck);
    third.split();
    for (std::size_t j = 0; j < stuck.primitives.size(); ++j) {
      const auto same = std::ranges::find(other.primitives, stuck.primitives[j].id, &Primitive::id);
      ASSERT_LE(distance(stuck.forces_n[j], other.forces_n[static_cast<std::size_t>(same - other.primitives.begin())]),
                tolerance_n);
      ASSERT_LE(distance(stuck.forces_n[j], third.forces_n[j]), tolerance_n) << "splitting again changes it";
    }
  }
}

TEST(LeastSplit, TurnsWithTheWorld) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    Stuck stuck = random_stuck(random, 2 + random.below(8), Shape::any);
    const Mat3 turn = random.rotation();
    Stuck turned = stuck;
    turned.balance.position_m = turn * stuck.balance.position_m;
    for (std::size_t j = 0; j < stuck.primitives.size(); ++j) {
      turned.primitives[j].position_m = turn * stuck.primitives[j].position_m;
      turned.primitives[j].direction = turn * stuck.primitives[j].direction;
      turned.forces_n[j] = turn * stuck.forces_n[j];
    }
    stuck.split();
    turned.split();
    for (std::size_t j = 0; j < stuck.primitives.size(); ++j) {
      ASSERT_LE(distance(turn * stuck.forces_n[j], turned.forces_n[j]), 1e-9 * strengths_n(stuck)) << i;
    }
  }
}

TEST(LeastSplit, IsSharedByCoincidentPrimitivesAsTheirStrengths) {
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    Stuck stuck = random_stuck(random, 1 + random.below(5), Shape::any);
    Primitive twin = stuck.primitives[0];
    twin.strength_n = random.below(4) == 0 ? 0.0 : random.uniform(0.1, 10.0);
    stuck.add(twin.kind, twin.direction, twin.strength_n, allowed(twin, twin.strength_n * random.in_cube(1.0)));
    stuck.split();
    EXPECT_LE(distance(twin.strength_n * stuck.forces_n[0], stuck.primitives[0].strength_n * stuck.forces_n.back()),
              1e-13 * strengths_n(stuck) * strengths_n(stuck));
    if (twin.strength_n == 0.0) {
      EXPECT_EQ(stuck.forces_n.back(), Vec3{});
    }
  }
}

TEST(LeastSplit, HasTheClosedFormsOfPairs) {
  const Vec3 z{0, 0, 1};
  {  // two planes of one normal: in proportion to strength
    Stuck stuck;
    stuck.add(PrimitiveKind::plane, z, 1.0, 0.9 * z);
    stuck.add(PrimitiveKind::plane, z, 3.0, {});
    EXPECT_TRUE(split_is_shared(stuck.primitives, stuck.balance));
    stuck.split();
    EXPECT_NEAR(stuck.forces_n[0].z, 0.225, 1e-15);
    EXPECT_NEAR(stuck.forces_n[1].z, 0.675, 1e-15);
  }
  {  // opposed planes do not press on each other
    Stuck stuck;
    stuck.add(PrimitiveKind::plane, z, 1.0, 0.9 * z);
    stuck.add(PrimitiveKind::plane, -z, 3.0, -0.5 * z);
    stuck.split();
    EXPECT_NEAR(stuck.forces_n[0].z, 0.4, 1e-15);
    EXPECT_EQ(norm(stuck.forces_n[1]), 0.0);
  }
  {  // a point and a plane: the plane helps along its normal, and only pushing
    for (const double push : {0.8, -0.8}) {
      Stuck stuck;
      stuck.add(PrimitiveKind::point, {}, 1.0, {0.3, 0, push});
      stuck.add(PrimitiveKind::plane, z, 3.0, {});
      stuck.split();
      EXPECT_NEAR(distance(stuck.forces_n[0], {0.3, 0, push > 0 ? 0.25 * push : push}), 0.0, 1e-15);
      EXPECT_NEAR(stuck.forces_n[1].z, push > 0 ? 0.75 * push : 0.0, 1e-15);
    }
  }
  {  // a point and a weak plane: the plane has its full strength, the point the rest
    Stuck stuck;
    stuck.add(PrimitiveKind::point, {}, 5.0, {0.5, 0, 4.9});
    stuck.add(PrimitiveKind::plane, z, 0.1, {});
    stuck.split();
    EXPECT_NEAR(stuck.forces_n[1].z, 0.1 * std::min(1.0, 4.9 / 5.1), 1e-14);
    EXPECT_NEAR(distance(total_n(stuck.forces_n), {0.5, 0, 4.9}), 0.0, 1e-14);
  }
  {  // two points hold a force together like one of their summed strength
    Stuck stuck;
    stuck.add(PrimitiveKind::point, {}, 1.0, {0.6, 0.8, 0.0});
    stuck.add(PrimitiveKind::point, {}, 4.0, {0.0, 0.0, 2.0});
    stuck.split();
    EXPECT_NEAR(distance(stuck.forces_n[0], {0.12, 0.16, 0.4}), 0.0, 1e-15);
    EXPECT_NEAR(distance(stuck.forces_n[1], {0.48, 0.64, 1.6}), 0.0, 1e-15);
  }
}

TEST(LeastSplit, LeavesUniqueForcesAlone) {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    Stuck stuck = random_stuck(random, 4, Shape::any);
    const std::size_t sticking = stuck.primitives.size();
    const Vec3& at = stuck.balance.position_m;
    // Slipping, left, directed, and a working drag.
    stuck.add(PrimitiveKind::point, {}, 1.0, {0, 1, 0});
    stuck.primitives.back().position_m = at + Vec3{0, 1e-3, 0};
    stuck.add(PrimitiveKind::plane, {0, 0, 1}, 1.0, {});
    stuck.primitives.back().position_m = at - Vec3{0, 0, 1e-3};
    stuck.add(PrimitiveKind::directed, {1, 0, 0}, 0.5, {0.5, 0, 0});
    stuck.add(PrimitiveKind::line, {1, 0, 0}, 1.0, {0, 1.5, 0}, 2.0);
    stuck.primitives.back().position_m = at + Vec3{0, 2.5e-4, 0};
    const std::vector<Vec3> given = stuck.forces_n;
    stuck.split();
    for (std::size_t j = sticking; j < given.size(); ++j) EXPECT_EQ(stuck.forces_n[j], given[j]) << j;
  }
  // A set with more directions than shared ones has one split only, which is the least.
  Stuck corner;
  corner.add(PrimitiveKind::plane, {1, 0, 0}, 1.0, {0.3, 0, 0});
  corner.add(PrimitiveKind::line, {1, 0, 0}, 2.0, {0, 0.4, -1.2});
  EXPECT_FALSE(split_is_shared(corner.primitives, corner.balance));
  corner.split();
  EXPECT_NEAR(distance(corner.forces_n[0], {0.3, 0, 0}), 0.0, 1e-15);
  EXPECT_NEAR(distance(corner.forces_n[1], {0, 0.4, -1.2}), 0.0, 1e-15);
}

// A drag has no force without motion: two points at one position share as without it, in any order.
TEST(LeastSplit, SharesWithADragThatStandsStill) {
  for (const bool drag_first : {true, false}) {
    Stuck stuck;
    stuck.add(PrimitiveKind::point, {}, 1.0, {0.9, 0, 0}, drag_first ? 2.0 : 0.0);
    stuck.add(PrimitiveKind::point, {}, 1.0, {}, drag_first ? 0.0 : 2.0);
    EXPECT_TRUE(split_is_shared(stuck.primitives, stuck.balance));
    stuck.split();
    for (const Vec3& u : stuck.forces_n) EXPECT_NEAR(u.x, 0.45, 1e-15);
  }
}

// Facets about an axis, with admissible forces of the corner.
void add_corner(Random& random, Stuck& stuck, double strength_n) {
  const Vec3 axis = random.direction();
  const auto first = stuck.primitives.size();
  Vec3 sum_n;
  for (int i = 2 + random.below(4); i > 0; --i) {
    const Vec3 normal = normalized(axis + 0.8 * random.direction());
    stuck.add(PrimitiveKind::corner, normal, strength_n, random.uniform(0.0, 0.5) * strength_n * normal);
    stuck.primitives.back().id.slot = static_cast<std::uint16_t>(first);
    sum_n += stuck.forces_n.back();
  }
  const double share = std::min(1.0, 0.9 * strength_n / std::max(1e-300, norm(sum_n)));
  for (std::size_t i = first; i < stuck.forces_n.size(); ++i) stuck.forces_n[i] *= share;
}

// A corner shares as one primitive, and its least sum is found from any split: no other split over its facets costs less.
TEST(LeastSplit, OfCornersSharesAsOneAndLeavesNoOtherDownhill) {
  Random random(10);
  for (int i = 0; i < 2000; ++i) {
    Stuck stuck = random_stuck(random, 1 + random.below(3), Shape::any);
    const std::size_t corner = stuck.primitives.size();
    const double s = random.uniform(0.1, 5.0);
    add_corner(random, stuck, s);
    const Vec3 before_n = total_n(stuck.forces_n);
    const double left_n = stuck.split();
    const double all_n = strengths_n(stuck);
    EXPECT_LE(left_n, 1e-12 * all_n) << i;
    EXPECT_LE(distance(before_n, total_n(stuck.forces_n)), 1e-12 * all_n);
    Vec3 own_n;
    int pressed = 0;
    for (std::size_t j = corner; j < stuck.primitives.size(); ++j) {
      EXPECT_GE(dot(stuck.forces_n[j], stuck.primitives[j].direction), 0.0);
      pressed += norm(stuck.forces_n[j]) > 0.0;
      own_n += stuck.forces_n[j];
    }
    EXPECT_LE(pressed, 3);
    EXPECT_LE(norm(own_n), s * (1.0 + 1e-12));
    // Moving some of the corner's force to the first primitive, or back, costs no less.
    const Primitive& other = stuck.primitives[0];
    if (!(other.strength_n > 0.0)) continue;
    const auto cost_of = [&](const Vec3& corner_n, const Vec3& other_n) {
      return norm_squared(corner_n) / s + norm_squared(other_n) / other.strength_n;
    };
    for (int k = 0; k < 20; ++k) {
      const Vec3 other_n = allowed(other, stuck.forces_n[0] + std::exp(random.uniform(-12, 0)) * random.in_cube(1.0));
      const Vec3 corner_n = own_n + stuck.forces_n[0] - other_n;
      Stuck one;
      one.balance = stuck.balance;
      for (std::size_t j = corner; j < stuck.primitives.size(); ++j) {
        one.primitives.push_back(stuck.primitives[j]);
        one.forces_n.push_back(j == corner ? corner_n : Vec3{});
      }
      one.split();  // the corner's admissible part of it
      if (distance(total_n(one.forces_n), corner_n) > 1e-13 * s) continue;
      EXPECT_GE(cost_of(corner_n, other_n), cost_of(own_n, stuck.forces_n[0]) * (1.0 - 1e-9) - 1e-9 * all_n) << i;
    }
  }
}

TEST(LeastSplit, OfACornerAloneIsItsOwn) {
  Random random(11);
  for (int i = 0; i < 500; ++i) {
    Stuck stuck;
    add_corner(random, stuck, 2.0);
    EXPECT_FALSE(split_is_shared(stuck.primitives, stuck.balance));
    const Vec3 before_n = total_n(stuck.forces_n);
    stuck.split();
    EXPECT_LE(distance(before_n, total_n(stuck.forces_n)), 1e-13);
    // A plane along one of its facets shares with it: by strength where the corner's force is along that, too.
    stuck.add(PrimitiveKind::plane, stuck.primitives[0].direction, 1.0, {});
    EXPECT_TRUE(split_is_shared(stuck.primitives, stuck.balance));
    for (std::size_t j = 1; j + 1 < stuck.forces_n.size(); ++j) stuck.forces_n[j] = {};
    stuck.forces_n[0] = 0.9 * stuck.primitives[0].direction;
    stuck.split();
    EXPECT_LE(distance(stuck.forces_n.back(), 0.3 * stuck.primitives[0].direction), 1e-13);
    EXPECT_LE(distance(stuck.forces_n[0], 0.6 * stuck.primitives[0].direction), 1e-13);
  }
}

// A plane that pushes across the direction in which a point is at its limit: the multiplier is at infinity.
TEST(LeastSplit, ReachesTheBorderOfWhatCanBeExerted) {
  Random random(8);
  double worst = 0.0;
  for (int i = 0; i < 500; ++i) {
    const Mat3 turn = random.rotation();
    Stuck stuck;
    const double s = random.uniform(0.1, 5.0), t = random.uniform(0.1, 5.0);
    stuck.add(PrimitiveKind::point, {}, s, s * (turn * Vec3{1, 0, 0}));
    stuck.add(PrimitiveKind::plane, turn * Vec3{0, 0, 1}, t, random.uniform(0.0, t) * (turn * Vec3{0, 0, 1}));
    const std::vector<Vec3> given = stuck.forces_n;
    const double left_n = stuck.split();
    worst = std::max(worst, left_n / (s + t));
    ASSERT_LE(left_n, 1e-12 * (s + t));
    for (int j = 0; j < 2; ++j) ASSERT_LE(distance(stuck.forces_n[j], given[j]), 1e-5);
  }
  std::printf("total missed at the border: at most %.2g of the strengths\n", worst);
}

TEST(LeastSplit, IsFiniteForArbitraryBitsAndAllocatesNothing) {
  Random random(9);
  const auto any = [&] {
    switch (random.below(4)) {
      case 0: return std::bit_cast<double>(random.bits());
      case 1: return std::numeric_limits<double>::quiet_NaN();
      case 2: return 0.0;
      default: return random.uniform(-2, 2);
    }
  };
  const auto any_vector = [&] { return random.below(3) ? Vec3{any(), any(), any()} : random.direction(); };
  std::vector<Primitive> primitives(6);
  std::vector<Vec3> forces_n(6);
  const long before = test::allocations;
  for (int i = 0; i < 200000; ++i) {
    const Balance balance{.position_m = random.below(2) ? Vec3{} : any_vector(), .error_bound_m = std::abs(any())};
    for (std::size_t j = 0; j < 6; ++j) {
      primitives[j] = {test::random_kind(random), {}, random.below(2) ? Vec3{} : any_vector(), any_vector(), any(), any()};
      if (i % 2 == 1 && random.below(2)) primitives[j].kind = PrimitiveKind::corner, primitives[j].strength_n = 1.0;
      forces_n[j] = any_vector();
    }
    const double left_n = least_split(primitives, balance, forces_n);
    split_is_shared(primitives, balance);
    if (!std::isfinite(left_n) || !std::ranges::all_of(forces_n, [](const Vec3& u) { return is_finite(u); })) {
      FAIL() << "not finite: problem " << i;
    }
  }
  EXPECT_EQ(test::allocations, before);
}

// Of feet on a plane the least split is linear in their place: t = s λ·(1, x, z), the multiplier of force and torque.
TEST(ForceSplit, OfCoplanarFeetIsLinearInTheirPlace) {
  test::Random random(11);
  for (const std::size_t feet : {4u, 16u, 64u}) {
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<Primitive> primitives(feet);
      std::vector<Vec3> levers_m(feet), forces_n(feet), linear_n(feet);
      const double slope_x = random.uniform(-5.0, 5.0), slope_z = random.uniform(-5.0, 5.0);
      for (std::size_t i = 0; i < feet; ++i) {
        levers_m[i] = {random.uniform(-0.03, 0.03), 0.01, random.uniform(-0.03, 0.03)};
        Primitive& plane = primitives[i];
        plane.kind = PrimitiveKind::plane;
        plane.id.foot = static_cast<std::uint16_t>(i);
        plane.position_m = levers_m[i];
        plane.direction = {0, 1, 0};
        plane.strength_n = random.uniform(1.0, 3.0);
        linear_n[i] = {0, plane.strength_n * (0.4 + slope_x * levers_m[i].x + slope_z * levers_m[i].z), 0};
      }
      // Any other split with this total and torque: shifts along Σt = Σtx = Σtz = 0 of four feet.
      forces_n = linear_n;
      const Vec3 *a = levers_m.data(), one{1, 1, 1}, x{a[0].x, a[1].x, a[2].x}, z{a[0].z, a[1].z, a[2].z};
      const Mat3 rows{{one, x, z}};
      const Vec3 others = 0.05 * (inverse(rows) * Vec3{1.0, a[3].x, a[3].z});
      if (std::abs(determinant(rows)) < 1e-5 || largest_component(others) > 0.3) continue;
      forces_n[3].y += 0.05;
      forces_n[0].y -= others.x, forces_n[1].y -= others.y, forces_n[2].y -= others.z;
      if (std::ranges::any_of(forces_n, [](const Vec3& force_n) { return force_n.y < 0.0; })) continue;
      const FeetOfRows at{levers_m, 0.05};
      EXPECT_TRUE(split_is_shared(primitives, {}, at));
      double strengths_n = 0.0;
      for (const Primitive& plane : primitives) strengths_n += plane.strength_n;
      EXPECT_LT(least_split(primitives, {}, forces_n, at), 3e-14 * strengths_n);
      for (std::size_t i = 0; i < feet; ++i) EXPECT_LT(norm(forces_n[i] - linear_n[i]), 1e-9) << feet << " " << i;
    }
  }
}

// Three feet that are not on a line share nothing; their forces are unique.
TEST(ForceSplit, OfThreeFeetIsUnique) {
  std::vector<Primitive> primitives(3);
  const std::vector<Vec3> levers_m{{0.01, 0, 0}, {-0.01, 0, 0.01}, {0, 0, -0.02}};
  for (std::size_t i = 0; i < 3; ++i) {
    primitives[i].kind = PrimitiveKind::plane;
    primitives[i].id.foot = static_cast<std::uint16_t>(i);
    primitives[i].position_m = levers_m[i];
    primitives[i].direction = {0, 1, 0};
    primitives[i].strength_n = 1.0;
  }
  EXPECT_FALSE(split_is_shared(primitives, {}, FeetOfRows{levers_m, 0.05}));
  EXPECT_TRUE(split_is_shared(primitives, {})) << "as a point";
}

}  // namespace split_test
}  // namespace palpa
