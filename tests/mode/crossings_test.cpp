// Level crossings on straight paths: found between any two samples, against brute force.
#include "palpa/mode/crossings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "palpa/data/analytic.h"
#include "tests/mode/searched.h"

namespace palpa {
namespace crossings_test {

using namespace test::searched;

// Of thousands of watched values, as from transfer functions, only the neighbours of the present value count, and where a plane
// holds on a neighbour the next but one.
TEST(FirstCrossing, IsTheSameAmongThousandsOfWatches) {
  std::mt19937 random(5);
  const FieldPtr field = grid_with(grid_field, {12, 12, 12}, [&](auto, auto, auto) { return uniform(random, -1, 1); });
  constexpr int count = 20'000;  // equally spaced from -1 to 1, in any order, each twice
  const auto value = [](int i) { return 2.0 * (i + 0.5) / count - 1.0; };
  std::vector<Threshold> watches;
  for (int i = 0; i < 2 * count; ++i) watches.push_back({0, value(i % count)});
  std::ranges::shuffle(watches, random);
  Searched all({field}, watches);
  int stopped = 0;
  for (int n = 0; n < 300; ++n) {
    const Vec3 from = in_box(random, field->bounds_m()),
               to = from + uniform(random, 0.0, 0.02) * (in_box(random, field->bounds_m()) - from);
    const int above = static_cast<int>(std::ceil(0.5 * count * (field->scalar(from).value + 1.0) - 0.5));
    std::vector<Threshold> near;
    for (int i = above - 3; i < above + 3; ++i) {
      if (i >= 0 && i < count) near.push_back({0, value(i)});
    }
    Searched few({field}, near);
    const bool held = n % 2 == 1;
    for (Searched* s : {&all, &few}) {
      s->forget();
      s->policy.clear();
      for (int i = above - 1; held && i <= above; ++i) s->sides.configure_events(s->policy, {0, value(i)}, CrossingRule::held);
    }
    EXPECT_TRUE(all.sides.is_watched(near.front()));
    EXPECT_FALSE(all.sides.is_watched({0, 0.5 * (value(7) + value(8))}));
    const Searched::Met one = all.search_as_configured(from, to), other = few.search_as_configured(from, to);
    EXPECT_EQ(one.share, other.share);
    EXPECT_EQ(one.stopped, other.stopped);
    ASSERT_EQ(all.crossings.empty(), few.crossings.empty());
    if (!one.stopped) continue;
    ++stopped;
    EXPECT_EQ(all.crossings.front().value, few.crossings.front().value);
  }
  EXPECT_GT(stopped, 100);
}

// Random noise, from crossing to crossing, against 100 samples per voxel: every change of sides in the samples is found, no
// others, with the stop just beyond it.
TEST(FirstCrossing, IsWhatManySamplesShow) {
  std::mt19937 random(1);
  for (const MakeGrid make : both) {
    for (const double bumps : {1.0, 0.15}) {  // noise everywhere; or waves, where whole bricks lie on one side
      const FieldPtr field = grid_with(make, {40, 30, 36}, [&](auto i, auto j, auto k) {
        return bumps * uniform(random, -1, 1) +
               (1 - bumps) * std::sin(0.11 * double(i)) * std::cos(0.13 * double(j)) * std::sin(0.1 * double(k) + 1);
      });
      int found = 0, missed = 0, ways = 0;
      for (int n = 0; n < 2500; ++n) {
        const double level = uniform(random, -0.4, 0.7);
        Searched s({field}, {{0, level}, {0, level + 0.05}, {0, level - 0.2}});
        const Vec3 from = in_box(random, field->bounds_m());
        Vec3 to = in_box(random, field->bounds_m());
        if (n % 5 == 1) to = {to.x, from.y, from.z};
        if (n % 5 == 2) to = from + uniform(random, 0.0, 0.05) * (to - from);
        s.forget();
        const Searched::Met met = s.search(from, to);
        ASSERT_FALSE(met.out_of_work);
        ++ways;
        const auto sides = [&](double share) {
          const double value = field->scalar(from + share * (to - from)).value;
          return int(value >= level) + int(value >= level + 0.05) + int(value >= level - 0.2);
        };
        const int at_start = sides(0.0);
        const double length = distance(from, to);
        const double tolerance = 1e-12 / length;  // a billionth of the spacing
        if (met.stopped) {
          ++found;
          ASSERT_NE(sides(met.share), at_start);
          ASSERT_FALSE(s.crossings.empty());
          ASSERT_TRUE(met.share <= tolerance || sides(met.share - tolerance) == at_start) << n;
        }
        const double end = met.share - tolerance;
        const int steps = static_cast<int>(end * length / 1e-5);
        for (int i = 1; i < steps; ++i) missed += sides(end * i / steps) != at_start;
      }
      EXPECT_EQ(missed, 0);
      EXPECT_GT(found, 1000);
      EXPECT_LT(found, ways);
    }
  }
}

// All crossings along a path, in successive searches, alternate and end on the samples' side.
TEST(FirstCrossing, OneAfterTheOtherTheyAddUp) {
  std::mt19937 random(2);
  for (const MakeGrid make : both) {
    const FieldPtr field = grid_with(make, {24, 24, 24}, [&](auto, auto, auto) { return uniform(random, -1, 1); });
    for (int n = 0; n < 500; ++n) {
      Searched s({field}, {{0, 0.1}});
      const Vec3 from = in_box(random, field->bounds_m()), to = in_box(random, field->bounds_m());
      s.forget();
      bool above = s.above(from, 0.1);
      Vec3 at = from;
      int stops = 0;
      while (true) {
        const Searched::Met met = s.search(at, to);
        if (!met.stopped) break;
        ASSERT_EQ(s.crossings.size(), 1u);
        ASSERT_EQ(s.crossings[0].up, !above);
        above = !above;
        at = at + met.share * (to - at);
        ASSERT_NEAR(field->scalar(at).value, 0.1, 1e-8);
        ASSERT_LT(++stops, 200);
      }
      ASSERT_EQ(above, s.above(to, 0.1)) << n;
    }
  }
}

// A wall of one voxel, at any angle and position, met by paths of any length.
TEST(FirstCrossing, NoWallIsTooThin) {
  std::mt19937 random(3);
  for (const MakeGrid make : both) {
    const FieldPtr field = grid_with(make, {64, 64, 64}, [](auto, auto, auto k) { return k == 31 ? 1000.0 : 0.0; });
    for (int n = 0; n < 3000; ++n) {
      // The wall is met wherever the interpolant reaches the level, up to its very top.
      const double top = make == grid_field ? 1000.0 : 4000.0 / 6.0;
      const double level = n % 3 == 0 ? top * (1 - std::pow(10.0, uniform(random, -10, -1))) : uniform(random, 1, 0.99 * top);
      Searched s({field}, {{0, level}});
      const Vec3 from{uniform(random, 0, 0.063), uniform(random, 0, 0.063), uniform(random, 0, 0.0285)};
      const Vec3 to{uniform(random, 0, 0.063), uniform(random, 0, 0.063), uniform(random, 0.0335, 0.063)};
      s.forget();
      const Searched::Met met = s.search(from, to);
      ASSERT_TRUE(met.stopped) << level;
      const double z = from.z + met.share * (to.z - from.z);
      ASSERT_LE(z, 0.031 + 1e-12);
      if (make == grid_field) {
        ASSERT_NEAR(z, 0.030 + level / 1000.0 * 1e-3, 1e-14);
      }
      ASSERT_TRUE(s.crossings[0].up);
      const Searched::Met out = s.search(from + met.share * (to - from), to);
      ASSERT_TRUE(out.stopped && !s.crossings[0].up);
    }
  }
}

// In one cell of a trilinear grid the diagonal's value is a cubic: up and down again between two samples.
TEST(FirstCrossing, FindsTwoWithinACell) {
  // Corners 0 and 1 of the cell's diagonal 0, the six others 1: 3 t (1 − t) along it, at most 3/4.
  const FieldPtr field = grid_with(grid_field, {2, 2, 2}, [](auto i, auto j, auto k) { return i == j && j == k ? 0.0 : 1.0; });
  const Vec3 from{}, to{1e-3, 1e-3, 1e-3};
  for (const double below : {0.1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
    Searched s({field}, {{0, 0.75 - below}});
    s.forget();
    const Searched::Met up = s.search(from, to);
    ASSERT_TRUE(up.stopped) << below;
    const double half = std::sqrt(below / 3.0);
    EXPECT_NEAR(up.share, 0.5 - half, 1e-9 + 1e-15 / half) << below;
    const Vec3 at = from + up.share * (to - from);
    const Searched::Met down = s.search(at, to);
    ASSERT_TRUE(down.stopped && !s.crossings[0].up) << below;
    EXPECT_NEAR(norm(at + down.share * (to - at)) / norm(to), 0.5 + half, 1e-9 + 1e-15 / half);
  }
  Searched past({field}, {{0, 0.75 + 1e-12}});
  past.forget();
  EXPECT_FALSE(past.search(from, to).stopped);
}

// A proxy on a level to the last bit lifts off along a path with a slight rise: samples and polynomials on either side of the
// level are rounding, no crossing.
TEST(FirstCrossing, RoundingOnTheLevelStopsNothing) {
  std::mt19937 random(11);
  for (const MakeGrid make : both) {
    const FieldPtr field = grid_with(make, {12, 12, 12}, [&](auto, auto, auto) { return uniform(random, 0, 255); });
    for (int n = 0; n < 3000; ++n) {
      const Vec3 from = in_box(random, {{0.001, 0.001, 0.001}, {0.01, 0.01, 0.01}});
      const ScalarSample here = field->scalar(from);
      const Vec3 to = from + 3e-4 * normalized(in_box(random, {{-1, -1, -1}, {1, 1, 1}}));
      const double slope = dot(here.gradient, to - from) / 3e-4;
      if (!(slope > 0.01 * norm(here.gradient))) continue;
      Searched s({field}, {{0, here.value}});
      s.forget();
      s.policy.clear();
      s.sides.configure_events(s.policy, {0, here.value}, CrossingRule::leaves_down);
      const Searched::Met met = s.search_as_configured(from, to);
      ASSERT_TRUE(!met.stopped || met.share > 1e-6) << n << ": " << met.share;
    }
  }
}

TEST(FirstCrossing, AFormulasLevelIsLocatedAsWell) {
  std::mt19937 random(4);
  const FieldPtr ball = sphere_field(0.05).fields[0].field;
  for (int n = 0; n < 300; ++n) {
    Searched s({ball}, {{0, 0.0}});
    const Vec3 from = in_box(random, {{-0.07, -0.07, -0.07}, {0.07, 0.07, 0.07}});
    const Vec3 to = in_box(random, {{-0.07, -0.07, -0.07}, {0.07, 0.07, 0.07}});
    s.forget();
    const Searched::Met met = s.search(from, to);
    // |from + t d| = R
    const Vec3 d = to - from;
    const double a = dot(d, d), b = dot(from, d), c = dot(from, from) - 0.05 * 0.05, under = b * b - a * c;
    double root = 2.0;
    if (under > 0.0) {
      const double one = (-b - std::sqrt(under)) / a, other = (-b + std::sqrt(under)) / a;
      root = one > 0.0 ? one : other > 0.0 ? other : 2.0;
    }
    if (under > 0.0 && std::sqrt(under) < 1e-3 * a) continue;
    ASSERT_EQ(met.stopped, root <= 1.0) << n;
    if (!met.stopped) continue;
    ASSERT_NEAR(met.share * norm(d), root * norm(d), 5e-12) << n;
  }
}

TEST(FirstCrossing, TouchingIsNotCrossing) {
  const FieldPtr hill = grid_with(grid_field, {3, 2, 2}, [](auto i, auto, auto) { return i == 1 ? 1.0 : 0.0; });
  const FieldPtr flat = grid_with(grid_field, {5, 5, 5}, [](auto, auto, auto k) { return double(k); });
  // Over the ridge just under the level; along the level's face on the near side; turning back at the level's far side.
  Searched ridge({hill}, {{0, 1.0 + 1e-15}});
  ridge.forget();
  EXPECT_FALSE(ridge.search({0, 5e-4, 5e-4}, {2e-3, 5e-4, 5e-4}).stopped);
  const double on_face = flat->scalar({1e-3, 1e-3, 2e-3}).value;  // 2, up to rounding
  Searched face({flat}, {{0, on_face}});
  face.forget();  // on the level: counts as above
  EXPECT_FALSE(face.search({1e-3, 1e-3, 2e-3}, {3e-3, 3e-3, 2e-3}).stopped);
  EXPECT_FALSE(face.search({3e-3, 3e-3, 2e-3}, {3e-3, 1e-3, 3e-3}).stopped);
  const Searched::Met down = face.search({3e-3, 1e-3, 3e-3}, {3e-3, 1e-3, 1e-3});
  EXPECT_TRUE(down.stopped);
  EXPECT_NEAR(down.share, 0.5, 1e-12);
}

TEST(FirstCrossing, PlateausAtTheLevelAreReached) {
  // A mask: 0 and 1, and the level is 1 itself; the plateau is of whole bricks.
  for (const double slope : {1.0, 0.7, 0.31}) {
    const FieldPtr mask = grid_with(grid_field, {40, 9, 9}, [](auto i, auto, auto) { return i >= 20 ? 1.0 : 0.0; });
    Searched s({mask}, {{0, 0.0}, {0, 1.0}});
    const Vec3 from{1e-3, 1e-3, 1e-3}, to{38.9e-3, 1e-3 + 6e-3 * slope, 2e-3};
    s.forget();
    const Searched::Met in = s.search(from, to);
    ASSERT_TRUE(in.stopped);
    EXPECT_NEAR(from.x + in.share * (to.x - from.x), 20e-3, 1e-12);
    const Vec3 at = from + in.share * (to - from);
    EXPECT_FALSE(s.search(at, to).stopped);
    const Searched::Met out = s.search(to, from);
    ASSERT_TRUE(out.stopped);
    EXPECT_NEAR(to.x + out.share * (from.x - to.x), 20e-3, 2e-12);
  }
}

TEST(FirstCrossing, WorkIsBoundedAndGoesOn) {
  // A formula is sampled every quarter of a millimetre: a path of a metre is more than one search.
  const FieldPtr plane = plane_field(10.0).fields[0].field;
  Searched s({plane}, {{0, 0.0}});
  Vec3 at{0, 0, 4.9};
  const Vec3 to{0, 0, -4.9};
  s.forget();
  int searches = 0;
  Searched::Met met;
  do {
    met = s.search(at, to);
    ASSERT_GT(met.share, 0.0);
    at = at + met.share * (to - at);
    ASSERT_LT(++searches, 100);
  } while (met.out_of_work);
  EXPECT_TRUE(met.stopped);
  EXPECT_NEAR(at.z, 0.0, 1e-9);

  std::mt19937 random(5);
  const FieldPtr noise = grid_with(grid_field, {400, 20, 20}, [&](auto, auto, auto) { return uniform(random, -1, 1); });
  Searched long_way({noise}, {{0, 2.0}, {0, -2.0}, {0, 0.999}, {0, -0.999}});
  const Vec3 from{0, 0.1e-3, 0.2e-3}, far{0.399, 18e-3, 17e-3};
  long_way.forget();
  const Searched::Met whole = long_way.search(from, far);
  EXPECT_TRUE(!whole.stopped || !long_way.crossings.empty() || whole.out_of_work);
}

// Pieces of length 0, as of any field on a path too short to separate its ends.
class WithoutLength : public Field {
 public:
  int components() const noexcept override { return 1; }
  ScalarSample scalar(const Vec3&) const noexcept override {
    ScalarSample sample;
    sample.value = -1.0, sample.inside = true;
    return sample;
  }
  PolynomialPiece piece_along(const Vec3&, const Vec3&, double begin, const ValueRange&) const noexcept override {
    PolynomialPiece piece;
    piece.end = begin, piece.inside = true, piece.degree = 0, piece.control[0] = -1.0;
    return piece;
  }
  double spacing_m() const noexcept override { return 1e-3; }
  Box bounds_m() const noexcept override { return {{-1e10, -1e10, -1e10}, {1e10, 1e10, 1e10}}; }
  double depth_m(const Vec3&) const noexcept override { return 1e9; }
  std::vector<ValueRange> value_ranges() const override { return {{-1.0, 1.0}}; }
};

TEST(FirstCrossing, WorkIsBoundedWhereTheWayIsRounding) {
  Searched one({std::make_shared<WithoutLength>()}, {{0, 0.0}});
  one.policy.clear();
  for (const double far_m : {0.1, 1e3, 1e6, 1e9}) {
    for (const double length_m : {1e-3, 1e-9, 1e-12}) {
      const Vec3 from_m{far_m, 0.0, 0.0}, to_m{far_m, length_m, 0.0};
      WorkBudget pieces(most_pieces);
      one.sides.first_event(0, from_m, to_m, one.policy, one.samples, pieces, one.event);
      EXPECT_EQ(one.event.kind, Event::Kind::out_of_work) << far_m << ", " << length_m;
      EXPECT_GE(pieces.left(), -most_pieces) << far_m << ", " << length_m;
      EXPECT_GT(one.event.share, 0.0) << far_m << ", " << length_m << ": it came somewhere";
    }
  }
}

TEST(FirstCrossing, TakesAnything) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  std::mt19937 random(6);
  const FieldPtr noise = grid_with(smooth_grid_field, {9, 9, 9}, [&](auto, auto, auto) { return uniform(random, -1, 1); });
  Searched s({noise, head_phantom().fields[0].field, lamb_oseen_vortex().fields[0].field},
             {{0, 0.1}, {1, 300.0}, {2, 0.0}, {7, 1.0}, {-1, 1.0}, {0, nan}, {0, infinity}, {0, -infinity}});
  s.edges = {0, 1, 2};
  const double numbers[] = {nan, infinity, -infinity, 1e308, -1e308, 1e20, 1e-300, 0.0, 4e-3, -0.1, 1e3};
  for (int n = 0; n < 20000; ++n) {
    const auto any = [&] { return numbers[random() % std::size(numbers)]; };
    const Vec3 from{any(), any(), any()}, to{any(), any(), any()};
    s.forget();
    const Searched::Met met = s.search(from, to);
    ASSERT_GE(met.share, 0.0);
    ASSERT_LE(met.share, 1.0);
    ASSERT_LE(s.crossings.size(), 18u);
  }
}

// The hand's frame: equal shares at any scale of the data.
TEST(FirstCrossing, DoesNotDependOnTheScale) {
  std::mt19937 random(7);
  const FieldPtr noise = grid_with(grid_field, {20, 20, 20}, [&](auto, auto, auto) { return uniform(random, -1, 1); });
  Searched plain({noise}, {{0, 0.2}}), scaled({posed(noise, {.scale = 1024.0})}, {{0, 0.2}}, {.scale = 1024.0});
  for (int n = 0; n < 500; ++n) {
    const Vec3 from = in_box(random, noise->bounds_m()), to = in_box(random, noise->bounds_m());
    plain.forget();
    scaled.forget();
    const Searched::Met a = plain.search(from, to), b = scaled.search(from, to);
    ASSERT_EQ(a.stopped, b.stopped);
    ASSERT_EQ(a.share, b.share);
  }
}

}  // namespace crossings_test
}  // namespace palpa
