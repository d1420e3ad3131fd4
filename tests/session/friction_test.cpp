// Static and kinetic friction with a viscous part: closed forms on a plane, invariants.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "palpa/data/analytic.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"
#include "tests/session/friction_work.h"
#include "tests/session/hands.h"

namespace palpa {
namespace friction_test {

constexpr double dt = 1e-3;
constexpr double stiffness_n_per_m = 800.0;

Scene scene_of(const Volume& data, const SurfaceAndFriction& surface, const Similarity& pose = {}) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
  SurfaceAndFriction mode = surface;
  mode.field = scene.add("data", data, pose);
  scene.add("surface", mode);
  return scene;
}

Vec3 along(const Vec3& force_n) { return {force_n.x, force_n.y, 0.0}; }

/// A hand on the plane z = 0, with a normal force [N] and tangential motion.
class OnAPlane {
 public:
  OnAPlane(const SurfaceAndFriction& surface, double normal_n, const Vec3& aside, double gives_way_m = 0.0)
      : session_(scene_of(plane_field(0.2), surface)),
        aside_(aside),
        at_m_{0.0, 0.0, -normal_n / stiffness_n_per_m - gives_way_m} {
    for (int i = 0; i <= 100; ++i) session_.tick({.position_m = {0, 0, 0.005 + 0.01 * i * (at_m_.z - 0.005)}}, dt);
  }
  Tick go(double by_m) {
    at_m_ += by_m * aside_;
    return tick_ = session_.tick({.position_m = at_m_}, dt);
  }
  /// Moves to a tangential pull of this many newtons on a sticking proxy.
  Tick pull(double tangential_n) { return go(dot(aside_, tick_.proxy_m - at_m_) + tangential_n / stiffness_n_per_m); }
  Tick stay(int ticks) {
    for (int i = 0; i < ticks; ++i) go(0.0);
    return tick_;
  }

 private:
  Session session_;
  Vec3 aside_, at_m_;
  Tick tick_;
};

SurfaceAndFriction level_with(double friction_n, double coefficient, double ratio, double drag_ns_per_m) {
  return {.levels = {{.value = 0.0, .strength_n = 8.0}},
          .friction_n = friction_n,
          .friction_coefficient = coefficient,
          .static_friction_ratio = ratio,
          .friction_ns_per_m = drag_ns_per_m};
}

Vec3 in_the_plane(test::Random& random) {
  const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
  return {std::cos(angle), std::sin(angle), 0.0};
}

// It holds up to ratio · μ · N (or ratio · friction_n), of rigid and of elastic levels, and then falls to μ · N.
TEST(StaticFriction, HoldsUpToTheRatioTimesTheKineticOne) {
  test::Random random(1);
  for (int i = 0; i < 300; ++i) {
    const bool coulomb = i % 2 == 0;
    const double normal_n = random.uniform(0.3, 3.0), ratio = random.uniform(1.0, 3.0);
    const double kinetic_n = coulomb ? 0.4 * normal_n : 0.3;
    SurfaceAndFriction surface = level_with(coulomb ? 0.0 : 0.3, coulomb ? 0.4 : 0.0, ratio, 0.0);
    double gives_way_m = 0.0;
    if (i % 4 < 2) {
      surface.levels[0].stiffness_n_per_m = 600.0;
      gives_way_m = normal_n / 600.0;
    }
    OnAPlane hand(surface, normal_n, in_the_plane(random), gives_way_m);
    const Tick touched = hand.stay(1);
    ASSERT_NEAR(touched.force_n.z, normal_n, 1e-6);
    const Tick held = hand.pull(0.98 * ratio * kinetic_n);
    EXPECT_NEAR(distance(held.proxy_m, touched.proxy_m), 0.0, 1e-9) << i;
    EXPECT_NEAR(norm(along(held.force_n)), 0.98 * ratio * kinetic_n, 1e-6) << i;
    const Tick slips = hand.pull(1.02 * ratio * kinetic_n);
    EXPECT_GT(distance(slips.proxy_m, touched.proxy_m), 1e-9) << i;
    EXPECT_LE(norm(along(slips.force_n)), ratio * kinetic_n + 1e-6) << i;
    EXPECT_NEAR(norm(along(hand.stay(1).force_n)), kinetic_n, 1e-6) << i << ": then it is the kinetic one";
  }
}

// Sliding steadily it is μ · N + c · v, for any ratio.
TEST(StaticFriction, IsTheKineticOneAndTheViscousPartWhileSliding) {
  test::Random random(2);
  for (int i = 0; i < 100; ++i) {
    const bool coulomb = i % 2 == 0;
    const double normal_n = random.uniform(0.3, 3.0), drag_ns_per_m = i % 3 == 0 ? 0.0 : random.uniform(0.1, 5.0);
    const double kinetic_n = i % 5 == 0 ? 0.0 : coulomb ? 0.4 * normal_n : 0.3, speed_m_per_s = random.uniform(0.005, 0.2);
    OnAPlane hand(
        level_with(coulomb ? 0.0 : kinetic_n, coulomb ? kinetic_n / normal_n : 0.0, random.uniform(1.0, 3.0), drag_ns_per_m),
        normal_n, in_the_plane(random));
    hand.pull(4.0 * kinetic_n + 0.1);
    Tick tick;
    for (int n = 0; n < 200; ++n) tick = hand.go(speed_m_per_s * dt);
    EXPECT_NEAR(norm(along(tick.force_n)), kinetic_n + drag_ns_per_m * speed_m_per_s, 1e-6) << i;
    EXPECT_NEAR(tick.force_n.z, normal_n, 1e-6) << i;
    // A stopped hand has no viscous part: the proxy comes up to its dry limit.
    EXPECT_NEAR(norm(along(hand.stay(2000).force_n)), kinetic_n, 1e-3) << i;
  }
}

TEST(StaticFriction, ReturnsWhereItHasHeldForTwentyMilliseconds) {
  for (const int held_ticks : {1, 10, 18, 22, 60}) {
    OnAPlane hand(level_with(0.3, 0.0, 2.0, 0.0), 1.0, {1, 0, 0});
    hand.stay(1);
    hand.pull(0.7);
    hand.stay(1 + held_ticks);  // the first of them falls to the kinetic force
    hand.pull(0.5);
    const double tangential_n = norm(along(hand.stay(1).force_n));
    EXPECT_NEAR(tangential_n, held_ticks > 20 ? 0.5 : 0.3, 1e-6) << held_ticks;
  }
}

// Under an encoder a slow hand stands still in most ticks. Sticking in each of them would be a buzz.
TEST(StaticFriction, DoesNotGripASlowHandBetweenTwoStepsOfItsEncoder) {
  const double step_m = 55e-6, speed_m_per_s = 0.005;
  OnAPlane hand(level_with(0.3, 0.0, 2.0, 0.0), 1.0, {1, 0, 0});
  hand.pull(0.7);
  double went_m = 0.0, worst_n = 0.0;
  for (int n = 1; n <= 1000; ++n) {
    const double to_m = step_m * std::floor(speed_m_per_s * dt * n / step_m);
    const Tick tick = hand.go(to_m - went_m);
    went_m = to_m;
    if (n > 1) worst_n = std::max(worst_n, norm(along(tick.force_n)));
  }
  EXPECT_LE(worst_n, 0.3 + 1e-6);
}

// Friction dissipates in every tick, and the ledger agrees: any hand, round surface, any ratio and drag.
TEST(StaticFriction, NeverBringsEnergyIn) {
  test::Random random(3);
  for (int run = 0; run < 40; ++run) {
    const bool coulomb = run % 2 == 0;
    SurfaceAndFriction surface =
        level_with(coulomb ? 0.0 : random.uniform(0.05, 0.5), coulomb ? random.uniform(0.05, 0.6) : 0.0,
                   random.uniform(1.0, 3.0), run % 3 == 0 ? 0.0 : random.uniform(0.1, 5.0));
    if (run % 4 == 1) surface.levels[0].stiffness_n_per_m = 500.0;
    Session session(scene_of(sphere_field(0.05), surface));
    const test::Wander hand(random, 0.08);
    SCOPED_TRACE(run);
    test::expect_that_friction_takes(session, hand);
  }
}

TEST(StaticFriction, TurnsWithTheWorldAndTheHand) {
  test::Random random(4);
  const Mat3 rotation = random.rotation();
  const SurfaceAndFriction surface = level_with(0.0, 0.3, 1.7, 0.8);
  Session a(scene_of(sphere_field(0.05), surface)), b(scene_of(sphere_field(0.05), surface, {.rotation = rotation}));
  const test::Wander hand(random, 0.08);
  int in_contact = 0;
  for (int i = 0; i < 4000; ++i) {
    const Tick ta = a.tick({.position_m = hand.at(dt * i)}, dt);
    const Tick tb = b.tick({.position_m = rotation * hand.at(dt * i)}, dt);
    ASSERT_NEAR(distance(tb.force_n, rotation * ta.force_n), 0.0, 1e-6) << i;
    in_contact += norm(ta.force_n) > 1e-3;
  }
  EXPECT_GT(in_contact, 100);
}

TEST(StaticFriction, IsOfMaterialAsOfLevels) {
  const SurfaceAndFriction surface{
      .strength_n = 8.0, .friction_n = 0.3, .static_friction_ratio = 2.0, .friction_ns_per_m = 2.0};
  OnAPlane hand(surface, 1.0, {0, 1, 0});
  const Tick touched = hand.stay(60);
  const Tick held = hand.pull(0.59);
  EXPECT_NEAR(distance(held.proxy_m, touched.proxy_m), 0.0, 1e-9);
  hand.pull(0.7);
  Tick tick;
  for (int n = 0; n < 200; ++n) tick = hand.go(0.05 * dt);
  EXPECT_NEAR(norm(along(tick.force_n)), 0.3 + 2.0 * 0.05, 1e-6);
}

// Records hold what a balance elsewhere needs: a friction line its coefficient and its plane, which give its strength, and
// whether a primitive goes with the proxy.
TEST(FrictionRecords, GiveTheStrengthFromThePlaneTheyName) {
  test::Random random(3);
  const Volume formula = plane_field(0.2);
  int lines = 0, planes = 0;
  for (const double coefficient : {0.0, 0.3, 1.0}) {
    Session session(scene_of(formula, level_with(coefficient > 0.0 ? 0.0 : 0.2, coefficient, 1.5, 0.4)));
    const test::Wander hand(random, 0.02);
    for (int tick = 0; tick < 2000; ++tick) {
      session.tick({.position_m = hand.at(dt * tick)}, dt);
      for (const SubStep& step : session.sub_steps()) {
        const auto rows = session.primitives().subspan(step.first_primitive, step.primitives);
        for (const PlacedPrimitive& row : rows) {
          const bool is_line = row.primitive.kind == PrimitiveKind::line;
          planes += !is_line;
          EXPECT_EQ(row.rides, row.primitive.position_m == step.start_m);
          EXPECT_TRUE(row.rides || !is_line);
          EXPECT_EQ(row.plane_slot >= 0, is_line && coefficient > 0.0);
          if (row.plane_slot < 0) continue;
          ++lines;
          double pressed_n = 0.0;
          for (const PlacedPrimitive& other : rows) {
            const bool is_its_plane = other.primitive.kind != PrimitiveKind::line &&
                                      other.primitive.id.mode == row.primitive.id.mode &&
                                      other.primitive.id.slot == row.plane_slot;
            if (is_its_plane) pressed_n += norm(other.force_n);
          }
          EXPECT_NEAR(row.primitive.strength_n, row.coefficient * pressed_n, 1e-6 * (1.0 + pressed_n)) << tick;
        }
      }
    }
  }
  EXPECT_GT(lines, 500);
  EXPECT_GT(planes, 500);
}

}  // namespace friction_test
}  // namespace palpa
