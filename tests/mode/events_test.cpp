// Stops of a search: held and left sides, edges of data, forbidden values, budget.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <random>

#include "palpa/data/analytic.h"
#include "tests/mode/searched.h"

namespace palpa {
namespace events_test {

using namespace test::searched;

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
  Searched::Met met = s.search_as_configured(from, to);
  EXPECT_NEAR(x(met), 3.5e-3, 1e-12);
  ASSERT_EQ(s.crossings.size(), 1u);
  EXPECT_EQ(s.crossings[0].value, 3.5);

  s.forget();
  s.policy.clear();
  s.sides.configure_events(s.policy, {0, 2.0}, CrossingRule::leaves_up);
  met = s.search_as_configured(from, {3e-3, 5e-4, 5e-4});
  EXPECT_FALSE(met.stopped);
  ASSERT_EQ(s.crossings.size(), 1u);
  EXPECT_TRUE(s.crossings[0].up);

  s.forget();
  s.policy.clear();
  s.sides.configure_events(s.policy, {0, 2.0}, CrossingRule::leaves_up);
  s.sides.configure_events(s.policy, {0, 3.5}, CrossingRule::held);
  met = s.search_as_configured(from, to);
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
  // Out, along, and in again in the next cell: a crossing.
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

// A level beyond a hole is met if the value behind the hole is on its other side.
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

// One walk of many short paths, whose search caches bounds of the fields, against searches without caches: equal events; no
// piece is visited where the bounds exclude an event.
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
      s.sides.first_event(0, at, to, s.policy, s.samples, enough, fresh);
      s.sides.first_event(0, at, to, s.policy, s.samples, left, s.event);
      ASSERT_EQ(s.event.kind, fresh.kind) << n;
      ASSERT_EQ(s.event.share, fresh.share) << n;
      ASSERT_EQ(s.event.crossings.size(), fresh.crossings.size());
      quiet += left.left() == most_pieces;
      crossed += s.event.kind == Event::Kind::crossing;
      edges += s.event.kind == Event::Kind::edge;
      s.sides.apply(0, s.event);
      at = at + s.event.share * (to - at);
    }
    EXPECT_GT(quiet, 5000);
    EXPECT_GT(crossed, 50);
    EXPECT_GE(edges, 3);
  }
}

// Feet of a tool meet what each of them would meet alone, in any order.
TEST(FirstEvent, OfAFootIsThatOfAPointOnItsPath) {
  std::mt19937 random(29);
  const FieldPtr noise = grid_with(grid_field, {20, 20, 20}, [&](auto, auto, auto) { return uniform(random, -1, 1); });
  const std::vector<FieldPtr> fields{noise};
  const std::vector<Threshold> watches{{0, 0.2}, {0, -0.4}};
  constexpr std::size_t feet = 3;
  StateArena live;
  Crossings together(live, watches, 1, feet);
  std::deque<Searched> alone;
  std::vector<Event> events;
  std::vector<Vec3> at;
  for (std::size_t foot = 0; foot < feet; ++foot) {
    alone.emplace_back(fields, watches);
    events.push_back(together.event());
    at.push_back(in_box(random, noise->bounds_m()));
  }
  EventPolicy policy = together.policy();
  int crossed = 0;
  for (int n = 0; n < 3000; ++n) {
    const std::size_t foot = random() % feet;
    const Vec3 to = at[foot] + 0.1 * (in_box(random, noise->bounds_m()) - at[foot]);
    const Searched::Met met = alone[foot].search(at[foot], to);
    policy.clear();
    WorkBudget work(most_pieces);
    together.first_event(foot, at[foot], to, policy, alone[foot].samples, work, events[foot]);
    ASSERT_EQ(events[foot].share, met.share);
    ASSERT_EQ(events[foot].crossings.size(), alone[foot].crossings.size());
    // Another foot takes the side that it is on: this one keeps its own.
    if (n % 2 == 0)
      together.take_side((foot + 1) % feet, watches[0], alone[(foot + 1) % feet].above(at[(foot + 1) % feet], 0.2));
    together.apply(foot, events[foot]);
    at[foot] = at[foot] + met.share * (to - at[foot]);
    crossed += events[foot].kind == Event::Kind::crossing;
  }
  EXPECT_GT(crossed, 300);
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
    const Searched::Met met = s.search_as_configured(from, to);
    EXPECT_EQ(s.event.kind, most < 7.0 ? Event::Kind::pierced : Event::Kind::none);
    EXPECT_NEAR(met.share, std::min(1.0, (most - 2.0) / 5.0), 1e-12);
    EXPECT_EQ(s.crossings.size(), most > 3.0 ? 1u : 0u);
    s.forget();
    s.policy.clear();
    for (const double level : {3.0, 5.0}) s.sides.configure_events(s.policy, {0, level}, CrossingRule::held);
    s.policy.fields[0].allowed.min = most;
    EXPECT_NEAR(s.search_as_configured(to, from).share, std::clamp((7.0 - most) / 5.0, 0.0, 1.0), 1e-12);
  }
}

// For any budget successive searches find equal events, and stay within it but for the first piece of each field, and slivers
// before it.
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
        s.sides.first_event(0, at, to, s.policy, s.samples, left, s.event);
        s.sides.apply(0, s.event);
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

}  // namespace events_test
}  // namespace palpa
