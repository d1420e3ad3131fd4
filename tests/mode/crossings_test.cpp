// Where a straight way passes a level: found whatever lies between two samples, beside brute force.
#include "palpa/mode/crossings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>

#include "palpa/data/analytic.h"
#include "palpa/data/grid.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"

namespace palpa {
namespace crossings_test {

using CrossingRule = EventPolicy::CrossingRule;

constexpr int most_pieces = 512;  // that one search may look at

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}
Vec3 in_box(std::mt19937& random, const Box& box) {
  return {uniform(random, box.low_m.x, box.high_m.x), uniform(random, box.low_m.y, box.high_m.y),
          uniform(random, box.low_m.z, box.high_m.z)};
}

using MakeGrid = FieldPtr (*)(const GridGeometry&, Voxels, double, double);
constexpr MakeGrid both[] = {grid_field, smooth_grid_field};

/// A grid of 1 mm whose voxels are value(i, j, k).
template <class Value>
FieldPtr grid_with(MakeGrid make, const std::array<std::int64_t, 3>& dims, Value value) {
  const auto data = std::make_shared<std::vector<float>>();
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) data->push_back(static_cast<float>(value(i, j, k)));
    }
  }
  const GridGeometry geometry{dims, 1e-3 * Mat3::identity(), {}};
  return make(geometry, {VoxelType::float32, 1, std::shared_ptr<const void>(data, data->data())}, 1.0, 0.0);
}

/// Fields, watched values, and a search along a way.
struct Searched {
  std::vector<FieldPtr> fields;
  Samples samples;
  StateArena live;
  Crossings sides;
  EventPolicy policy;
  Event event;
  std::vector<Crossing> crossings;
  std::vector<std::int32_t> edges;  // fields whose edges stop the way

  struct Met {
    double share = 1.0;
    bool stopped = false;
    bool edge = false;
    bool out_of_work = false;
  };

  Searched(std::vector<FieldPtr> given, std::vector<Threshold> watched, const Similarity& map = {})
      : fields(std::move(given)),
        samples(fields, map),
        sides(live, watched, fields.size()),
        policy(sides.policy()),
        event(sides.event()) {}
  /// The sides are those that the next search sets out from.
  void forget() { sides.reset(); }
  void stand(const Vec3& at_m) {
    sides.reset();
    search(at_m, at_m + Vec3{1e-6, 0.0, 0.0});
  }
  Met search(const Vec3& from_m, const Vec3& to_m) {
    policy.clear();
    return search_as_told(from_m, to_m);
  }
  Met search_as_told(const Vec3& from_m, const Vec3& to_m) {
    for (const std::int32_t field : edges) policy.fields[static_cast<std::size_t>(field)].stops_at_edges = true;
    WorkBudget pieces(most_pieces);
    sides.first_event(from_m, to_m, policy, samples, pieces, event);
    sides.apply(event);
    crossings = event.crossings;
    const bool stopped = event.kind != Event::Kind::none;
    return {event.share, stopped, event.kind == Event::Kind::edge, event.kind == Event::Kind::out_of_work};
  }
  bool above(const Vec3& at_m, double level) {
    const ScalarSample s = fields[0]->scalar(at_m);
    return s.value >= level;
  }
};

// Of thousands of watched values, as transfer functions bring them, those next to the present one decide, and where a plane
// holds on one of them the next but one: the same as if there were no others.
TEST(FirstCrossing, IsTheSameAmongThousandsOfWatches) {
  std::mt19937 random(5);
  const FieldPtr field = grid_with(grid_field, {12, 12, 12}, [&](auto, auto, auto) { return uniform(random, -1, 1); });
  constexpr int count = 20'000;  // at equal distances from -1 to 1, in any order, each twice
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
    const Searched::Met one = all.search_as_told(from, to), other = few.search_as_told(from, to);
    EXPECT_EQ(one.share, other.share);
    EXPECT_EQ(one.stopped, other.stopped);
    ASSERT_EQ(all.crossings.empty(), few.crossings.empty());
    if (!one.stopped) continue;
    ++stopped;
    EXPECT_EQ(all.crossings.front().value, few.crossings.front().value);
  }
  EXPECT_GT(stopped, 100);
}

// Random noise, walked from crossing to crossing, beside 100 samples per voxel: every change of sides that samples
// show is found, nothing is found where they show none, and the stop is just beyond the change.
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
        const double hair = 1e-12 / length;  // a billionth of the spacing
        if (met.stopped) {
          ++found;
          ASSERT_NE(sides(met.share), at_start);
          ASSERT_FALSE(s.crossings.empty());
          ASSERT_TRUE(met.share <= hair || sides(met.share - hair) == at_start) << n;
        }
        const double end = met.share - hair;
        const int steps = static_cast<int>(end * length / 1e-5);
        for (int i = 1; i < steps; ++i) missed += sides(end * i / steps) != at_start;
      }
      EXPECT_EQ(missed, 0);
      EXPECT_GT(found, 1000);
      EXPECT_LT(found, ways);
    }
  }
}

// All crossings along a way, one search after the other, alternate and end on the side that samples show.
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

// A wall of one voxel, at any angle and any place, met by ways of any length.
TEST(FirstCrossing, NoWallIsTooThin) {
  std::mt19937 random(3);
  for (const MakeGrid make : both) {
    const FieldPtr field = grid_with(make, {64, 64, 64}, [](auto, auto, auto k) { return k == 31 ? 1000.0 : 0.0; });
    for (int n = 0; n < 3000; ++n) {
      // The wall is felt wherever the interpolant reaches the level, however thin that layer is: up to its very top.
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

// A proxy on a level, to the last bit, that lifts off along a way which first rises a little: rounding, which has samples and
// polynomials on either side of the level there, is no crossing to stop for.
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
      const Searched::Met met = s.search_as_told(from, to);
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
    if (under > 0.0 && std::sqrt(under) < 1e-3 * a) continue;  // grazed
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
  const double on_face = flat->scalar({1e-3, 1e-3, 2e-3}).value;  // 2, as rounding has it
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

TEST(CrossingRule, HeldCrossesNothingAndLeaveOnlyOnce) {
  // Up through 2 at x = 2 mm, down again at 6 mm, up at 10 mm.
  const FieldPtr waves =
      grid_with(grid_field, {13, 2, 2}, [](auto i, auto, auto) { return double(i % 8 <= 4 ? i % 8 : 8 - i % 8); });
  const Vec3 from{0.5e-3, 5e-4, 5e-4}, to{11.5e-3, 5e-4, 5e-4};
  const auto x = [&](const Searched::Met& met) { return (from + met.share * (to - from)).x; };
  Searched s({waves}, {{0, 2.0}, {0, 3.5}});

  s.forget();
  s.policy.clear();
  s.sides.configure_events(s.policy, {0, 2.0}, CrossingRule::held);
  Searched::Met met = s.search_as_told(from, to);
  EXPECT_NEAR(x(met), 3.5e-3, 1e-12);
  ASSERT_EQ(s.crossings.size(), 1u);
  EXPECT_EQ(s.crossings[0].value, 3.5);

  s.forget();
  s.policy.clear();
  s.sides.configure_events(s.policy, {0, 2.0}, CrossingRule::leaves_up);
  met = s.search_as_told(from, {3e-3, 5e-4, 5e-4});
  EXPECT_FALSE(met.stopped);
  ASSERT_EQ(s.crossings.size(), 1u);
  EXPECT_TRUE(s.crossings[0].up);

  s.forget();
  s.policy.clear();
  s.sides.configure_events(s.policy, {0, 2.0}, CrossingRule::leaves_up);
  s.sides.configure_events(s.policy, {0, 3.5}, CrossingRule::held);
  met = s.search_as_told(from, to);
  EXPECT_NEAR(x(met), 6e-3, 1e-12) << "what was left is met again";
  ASSERT_EQ(s.crossings.size(), 2u);
  EXPECT_TRUE(s.crossings[0].up);
  EXPECT_FALSE(s.crossings[1].up);
}

TEST(FirstCrossing, ADisplacedProxyThatGoesBackHasCrossedNothing) {
  const FieldPtr ramp = grid_with(grid_field, {9, 9, 9}, [](auto, auto, auto k) { return double(k); });
  Searched s({ramp}, {{0, 4.0}});
  const Vec3 outside{4e-3, 4e-3, 3.9e-3}, inside{4e-3, 4e-3, 4.001e-3};
  s.stand(outside);
  EXPECT_FALSE(s.search(inside, {4e-3, 4e-3, 3.5e-3}).stopped) << "it stands on the level, a little inside, and leaves";
  EXPECT_TRUE(s.crossings.empty());
  s.stand(outside);
  const Searched::Met met = s.search(inside, {4e-3, 4e-3, 4.5e-3});
  EXPECT_TRUE(met.stopped) << "it goes on in";
  EXPECT_LT(met.share, 1e-9);
  s.stand(outside);
  // Out, along, and in again in the next cell: that is a crossing.
  EXPECT_FALSE(s.search(inside, {4e-3, 4e-3, 3.9e-3}).stopped);
  EXPECT_TRUE(s.search({4e-3, 4e-3, 3.9e-3}, {4e-3, 4e-3, 7e-3}).stopped);
}

TEST(Edges, StopOnlyWhereAskedTo) {
  const auto holed = [](auto i, auto, auto) {
    return i >= 20 && i < 30 ? std::numeric_limits<float>::quiet_NaN() : (i < 20 ? 0.f : 5.f);
  };
  for (const MakeGrid make : both) {
    const FieldPtr field = grid_with(make, {50, 9, 9}, holed);
    const Vec3 from{-0.01, 4e-3, 4e-3}, to{0.07, 4.3e-3, 4.1e-3};
    const double margin = make == grid_field ? 0.0 : 1e-3;  // the spline reaches one voxel further
    Searched s({field, lamb_oseen_vortex().fields[0].field}, {{0, 3.0}});
    s.forget();
    EXPECT_FALSE(s.search(from, to).stopped) << "beyond the hole the watch takes its side anew";
    s.edges = {0};
    s.forget();
    Vec3 at = from;
    std::vector<double> met_at;
    for (int n = 0; n < 10; ++n) {
      const Searched::Met met = s.search(at, to);
      if (!met.stopped) break;
      ASSERT_TRUE(met.edge);
      at = at + met.share * (to - at);
      met_at.push_back(at.x);
      ASSERT_EQ(field->scalar(at).inside, n % 2 == 0) << n;
    }
    ASSERT_EQ(met_at.size(), 4u);
    const double expected[] = {0.0, 19e-3 - margin, 30e-3 + margin, 49e-3};
    for (int n = 0; n < 4; ++n) EXPECT_NEAR(met_at[static_cast<std::size_t>(n)], expected[n], 2e-9);
    s.edges = {1};
    s.forget();
    const Searched::Met met = s.search({-0.07, 0, 0}, {0, 0, 0});
    EXPECT_TRUE(met.edge);
    EXPECT_NEAR(-0.07 + met.share * 0.07, -0.06, 1e-9);
    s.edges.clear();
    s.forget();
    EXPECT_FALSE(s.search(from, to).stopped);
  }
}

// After a hole on whose far side the value is on the other side, a level there is met all the same.
TEST(FirstCrossing, BehindAHoleSidesAreTakenAnew) {
  const auto value = [](auto i, auto, auto) {
    return i < 10 ? 0.0f : i < 20 ? std::numeric_limits<float>::quiet_NaN() : i < 30 ? 5.0f : 1.0f;
  };
  const FieldPtr field = grid_with(grid_field, {50, 4, 4}, value);
  Searched s({field}, {{0, 3.0}});
  const Vec3 from{1e-3, 1.2e-3, 1.3e-3}, to{45e-3, 2e-3, 2e-3};
  s.forget();
  const Searched::Met met = s.search(from, to);
  ASSERT_TRUE(met.stopped);
  EXPECT_NEAR(from.x + met.share * (to.x - from.x), 29.5e-3, 1e-12);
  EXPECT_FALSE(s.crossings[0].up);
}

TEST(FirstCrossing, WorkIsBoundedAndGoesOn) {
  // A formula is looked at every quarter of a millimetre: a way of a metre is more than one search.
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

// One walk of many short ways, whose search remembers what bounds the fields, beside searches that remember nothing: the same
// events. And where the bounds leave no room for one, no piece is looked at.
// Its pieces have no length, as those of any field where a way is shorter than its ends can be told.
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
      one.sides.first_event(from_m, to_m, one.policy, one.samples, pieces, one.event);
      EXPECT_EQ(one.event.kind, Event::Kind::out_of_work) << far_m << ", " << length_m;
      EXPECT_GE(pieces.left(), -most_pieces) << far_m << ", " << length_m;
      EXPECT_GT(one.event.share, 0.0) << far_m << ", " << length_m << ": it came somewhere";
    }
  }
}

TEST(FirstEvent, IsTheSameWhateverIsRemembered) {
  std::mt19937 random(12);
  for (const MakeGrid make : both) {
    const auto wave = [&](auto i, auto j, auto k) {
      const bool hole = i > 20 && i < 26 && j > 10 && j < 24;
      return hole ? std::numeric_limits<double>::quiet_NaN()
                  : std::sin(0.3 * double(i)) + std::cos(0.4 * double(j)) + std::sin(0.2 * double(k)) +
                        uniform(random, -0.02, 0.02);
    };
    const FieldPtr one = grid_with(make, {32, 32, 32}, wave), other = grid_with(make, {32, 32, 32}, wave);
    Searched s({one, other}, {{0, 0.5}, {0, -0.5}, {1, 0.0}, {1, 0.02}});
    const auto hand_m = [](double t) {
      return 0.0155 * Vec3{1 + 0.9 * std::sin(t), 1 + 0.9 * std::sin(1.3 * t), 1 + 0.9 * std::cos(0.7 * t)};
    };
    Vec3 at = hand_m(0.0);
    int quiet = 0, crossed = 0, edges = 0;
    for (int n = 0; n < 20000; ++n) {
      const Vec3 to = hand_m(1e-3 * n);
      s.edges = n % 3 != 0 ? std::vector<std::int32_t>{0} : std::vector<std::int32_t>{};
      s.policy.clear();
      s.policy.fields[1].allowed = n % 2 == 0 ? ValueRange{-1.0, 1.0} : s.policy.fields[1].allowed;
      for (const std::int32_t field : s.edges) s.policy.fields[static_cast<std::size_t>(field)].stops_at_edges = true;
      Event fresh = s.sides.event();
      WorkBudget enough(most_pieces), left(most_pieces);
      s.sides.first_event(at, to, s.policy, s.samples, enough, fresh);
      s.sides.first_event(at, to, s.policy, s.samples, left, s.event);
      ASSERT_EQ(s.event.kind, fresh.kind) << n;
      ASSERT_EQ(s.event.share, fresh.share) << n;
      ASSERT_EQ(s.event.crossings.size(), fresh.crossings.size());
      quiet += left.left() == most_pieces;
      crossed += s.event.kind == Event::Kind::crossing;
      edges += s.event.kind == Event::Kind::edge;
      s.sides.apply(s.event);
      at = at + s.event.share * (to - at);
    }
    EXPECT_GT(quiet, 5000);
    EXPECT_GT(crossed, 50);
    EXPECT_GE(edges, 3);
  }
}

TEST(FirstEvent, IsWhereAValueIsNotAllowed) {
  const FieldPtr ramp = grid_with(grid_field, {9, 9, 9}, [](auto, auto, auto k) { return double(k); });
  Searched s({ramp}, {{0, 3.0}, {0, 5.0}});
  const Vec3 from{4e-3, 4e-3, 2e-3}, to{4e-3, 4e-3, 7e-3};
  for (const double most : {2.5, 3.5, 4.0, 6.5, 8.0}) {
    s.forget();
    s.policy.clear();
    s.sides.configure_events(s.policy, {0, 3.0}, CrossingRule::leaves_up);
    s.sides.configure_events(s.policy, {0, 5.0}, CrossingRule::held);
    s.policy.fields[0].allowed.max = most;
    const Searched::Met met = s.search_as_told(from, to);
    EXPECT_EQ(s.event.kind, most < 7.0 ? Event::Kind::pierced : Event::Kind::none);
    EXPECT_NEAR(met.share, std::min(1.0, (most - 2.0) / 5.0), 1e-12);
    EXPECT_EQ(s.crossings.size(), most > 3.0 ? 1u : 0u);
    s.forget();
    s.policy.clear();
    for (const double level : {3.0, 5.0}) s.sides.configure_events(s.policy, {0, level}, CrossingRule::held);
    s.policy.fields[0].allowed.min = most;
    EXPECT_NEAR(s.search_as_told(to, from).share, std::clamp((7.0 - most) / 5.0, 0.0, 1.0), 1e-12);
  }
}

// However little may be looked at, the same events are found, one search after the other; and no search looks at more than it
// may, but for the first piece of each field, and slivers before it.
TEST(FirstEvent, IsFoundWithAnyBudget) {
  std::mt19937 random(13);
  const auto noise = [&](auto, auto, auto) { return uniform(random, -1, 1); };
  const std::vector<FieldPtr> fields{grid_with(grid_field, {30, 30, 30}, noise),
                                     grid_with(smooth_grid_field, {30, 30, 30}, noise)};
  for (int n = 0; n < 200; ++n) {
    const Vec3 from = in_box(random, fields[0]->bounds_m()), to = in_box(random, fields[0]->bounds_m());
    std::vector<double> found[2];
    for (const int budget : {1000, n % 7}) {
      Searched s(fields, {{0, 0.3}, {1, 0.1}, {1, -0.2}});
      s.policy.clear();
      double gone = 0.0;
      for (int searches = 0; gone < 1.0 && searches < 2000; ++searches) {
        WorkBudget left(budget);
        const Vec3 at = from + gone * (to - from);
        s.sides.first_event(at, to, s.policy, s.samples, left, s.event);
        s.sides.apply(s.event);
        ASSERT_GE(left.left(), -16);
        gone += s.event.share * (1.0 - gone);
        if (s.event.kind == Event::Kind::none) gone = 1.0;
        if (s.event.kind == Event::Kind::crossing) found[budget == 1000 ? 0 : 1].push_back(gone);
      }
      ASSERT_EQ(gone, 1.0);
    }
    ASSERT_EQ(found[0].size(), found[1].size()) << n;
    for (std::size_t i = 0; i < found[0].size(); ++i) ASSERT_NEAR(found[0][i], found[1][i], 1e-9);
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

// The hand's frame: the same shares whatever the scale of the data.
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
