// The least split of forces over a session's modes, in any order.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"
#include "tests/session/hands.h"

namespace palpa {
namespace split_test {

constexpr double dt = 1e-3;

// Balances are known to 1e-9 m, 5e-7 N here.
constexpr double tolerance_n = 1e-6;

// Two surfaces on one level, a rail, and air that holds: all share, in any order.
Scene sharing(const std::vector<int>& order, double drag_ns_per_m) {
  Scene scene({.stiffness_n_per_m = 500});
  const FieldRef ball = scene.add("ball", sphere_field(0.05));
  const FieldRef flow = scene.add("flow", burgers_vortex(), {.scale = 4.0});
  const auto surface = [&](double strength_n) {
    return SurfaceAndFriction{
        .field = ball, .levels = {{.name = "skin", .value = 0.0, .strength_n = strength_n}}, .friction_n = 0.3};
  };
  for (const int mode : order) {
    switch (mode) {
      case 0: scene.add("soft", surface(1.0)); break;
      case 1: scene.add("firm", surface(3.0)); break;
      case 2: scene.add("rail", Follow{.field = flow, .strength_n = 0.4, .drag_ns_per_m = drag_ns_per_m}); break;
      case 3: scene.add("air", Viscosity{.field = ball, .strength_n = 0.2, .drag_ns_per_m = drag_ns_per_m}); break;
    }
  }
  return scene;
}

std::size_t number_of(const Session& session, const std::string& name) {
  const auto& modes = session.scene().modes();
  return static_cast<std::size_t>(std::ranges::find(modes, name, &SceneMode::name) - modes.begin());
}

class Split : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Drags, Split, testing::Values(0.0, 1.5));

TEST_P(Split, DoesNotDependOnTheOrderOfTheModes) {
  std::vector<int> order{0, 1, 2, 3};
  Session reference(sharing(order, GetParam()));
  std::vector<Session> others;
  for (int i = 1; std::ranges::next_permutation(order).found; ++i) {
    if (i % 3 == 0) others.emplace_back(sharing(order, GetParam()));
  }
  ASSERT_EQ(others.size(), 7u);

  test::Random random(3);
  const test::Wander hand(random, 0.06);
  int compared = 0, shared = 0, law_differs = 0;
  double worst_n = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Probe probe{.position_m = hand.at(i * dt)};
    reference.tick(probe, dt);
    for (Session& other : others) {
      other.tick(probe, dt);
      // At the edge of a break-through the last bit decides; from then on the two runs differ.
      const double parted_m =
          distance(reference.sub_steps().back().balance.position_m, other.sub_steps().back().balance.position_m);
      if (parted_m > reference.sub_steps().back().balance.error_bound_m + exact_bound_m) continue;
      ++compared;
      for (std::size_t m = 0; m < 4; ++m) {
        const ModeForce& mode = reference.modes()[m];
        const std::size_t same = number_of(other, reference.scene().modes()[m].name);
        const double apart_n = distance(mode.force_n, other.modes()[same].force_n);
        worst_n = std::max(worst_n, apart_n);
        ASSERT_LE(apart_n, tolerance_n) << "tick " << i << ", mode " << m;
        ASSERT_EQ(mode.split_shared, other.modes()[same].split_shared);
        shared += mode.split_shared;

        Vec3 law_n, law_there_n;
        for (const PlacedPrimitive& p : reference.primitives().last(reference.sub_steps().back().primitives)) {
          if (p.primitive.id.mode == m) law_n += p.force_n;
        }
        for (const PlacedPrimitive& p : other.primitives().last(other.sub_steps().back().primitives)) {
          if (p.primitive.id.mode == same) law_there_n += p.force_n;
        }
        law_differs += distance(law_n, law_there_n) > 1e-3;
      }
    }
  }
  std::printf("%d shares of modes in other orders, at most %.2g N apart; the law's own split differs in %d\n", shared, worst_n,
              law_differs);
  EXPECT_GT(compared, 7 * 2000 * 9 / 10);
  EXPECT_GT(shared, 1500);
  EXPECT_GT(law_differs, 100) << "the law's split does not depend on the order either: this test says nothing";
}

TEST_P(Split, KeepsWhatTheLawExertsInAll) {
  Session session(sharing({2, 0, 3, 1}, GetParam()));
  test::Random random(4);
  const test::Wander hand(random, 0.06);
  int shared = 0;
  for (int i = 0; i < 5000; ++i) {
    session.tick({.position_m = hand.at(i * dt)}, dt);
    Vec3 law_n, shown_n;
    double strengths_n = 0.0;
    for (const PlacedPrimitive& p : session.primitives().last(session.sub_steps().back().primitives)) {
      law_n += p.force_n;
      strengths_n += p.primitive.strength_n;
    }
    int primitives = 0;
    for (const ModeForce& mode : session.modes()) {
      shown_n += mode.force_n;
      primitives += mode.primitives;
      shared += mode.split_shared;
    }
    ASSERT_LE(distance(law_n, shown_n), 1e-12 * strengths_n) << i;
    ASSERT_EQ(static_cast<std::uint32_t>(primitives), session.sub_steps().back().primitives);
  }
  EXPECT_GT(shared, 300);
}

TEST_P(Split, IsToldTheSameHoweverOftenSomeoneAsks) {
  Session asked(sharing({0, 1, 2, 3}, GetParam())), silent(sharing({0, 1, 2, 3}, GetParam()));
  test::Random random(5);
  const test::Wander hand(random, 0.06);
  for (int i = 0; i < 2000; ++i) {
    const Probe probe{.position_m = hand.at(i * dt)};
    const Tick a = asked.tick(probe, dt), b = silent.tick(probe, dt);
    ASSERT_EQ(a.proxy_m, b.proxy_m) << "asking who pushes changes what is felt";
    const std::vector<ModeForce> once(asked.modes().begin(), asked.modes().end());
    for (std::size_t m = 0; m < 4; ++m) ASSERT_EQ(once[m].force_n, asked.modes()[m].force_n);
  }
  // A tick without a probe has no forces by mode.
  asked.tick({.valid = false}, dt);
  for (const ModeForce& mode : asked.modes()) {
    EXPECT_EQ(mode.force_n, Vec3{});
    EXPECT_EQ(mode.primitives, 0);
  }
}

}  // namespace split_test
}  // namespace palpa
