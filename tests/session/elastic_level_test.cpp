// Levels with a stiffness of their own, along the proxy's path.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <numbers>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/data/grid.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"
#include "tests/session/hands.h"

namespace palpa {
namespace elastic_level_test {

constexpr double dt = 1e-3;
constexpr double k = 800.0;
constexpr double radius_m = 0.05;

using Level = SurfaceAndFriction::Level;

// A ball whose values are depths [m].
Scene ball(std::vector<Level> levels, bool as_grid = false, double friction_coefficient = 0.0) {
  Scene scene({.stiffness_n_per_m = k});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
  const FieldRef field = scene.add("ball", as_grid ? sampled(sphere_field(radius_m), 49) : sphere_field(radius_m));
  scene.add("flesh",
            SurfaceAndFriction{.field = field, .levels = std::move(levels), .friction_coefficient = friction_coefficient});
  return scene;
}

double in_series(double stiffness_n_per_m) { return 1.0 / (1.0 / k + 1.0 / stiffness_n_per_m); }

struct Pressed {
  Session session;
  double depth_m = -1e-3;
  Vec3 from;
  int onsets = 0, breaks = 0;

  explicit Pressed(const Scene& scene, const Vec3& direction = {0, 0, 1}) : session(scene), from(direction) {
    session.tick({.position_m = (radius_m - depth_m) * from}, dt);
  }
  Tick to(double new_depth_m) {
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(new_depth_m - depth_m) / 5e-5)));
    Tick tick;
    for (int i = 1; i <= steps; ++i) {
      tick = session.tick({.position_m = (radius_m - depth_m - (new_depth_m - depth_m) * i / steps) * from}, dt);
      for (const SessionEvent& event : session.events()) {
        onsets += event.kind == SessionEventKind::onset;
        breaks += event.kind == SessionEventKind::break_through;
      }
    }
    depth_m = new_depth_m;
    return tick;
  }
};

TEST(ElasticLevel, IsASpringInSeriesWithTheCoupling) {
  test::Random random(1);
  for (const bool as_grid : {false, true}) {
    for (const double stiffness : {100.0, 400.0, 3000.0}) {
      const Vec3 direction = as_grid ? random.direction() : Vec3{0, 0, 1};
      Pressed pressed(ball({{.value = 0.0, .strength_n = 5.0, .stiffness_n_per_m = stiffness}}, as_grid), direction);
      const double surface_m = as_grid ? 2e-5 : 1e-9;  // by the interpolant
      for (const double depth_m : {0.5e-3, 1e-3, 4e-3, 2e-3}) {
        const Tick tick = pressed.to(depth_m);
        const double force_n = in_series(stiffness) * depth_m;
        EXPECT_NEAR(norm(tick.force_n), force_n, in_series(stiffness) * surface_m + 1e-6) << stiffness << " " << depth_m;
        EXPECT_NEAR(radius_m - norm(tick.proxy_m), force_n / stiffness, surface_m + 1e-7) << "how far it gives way";
      }
      EXPECT_EQ(pressed.onsets, 1);
      EXPECT_EQ(norm(pressed.to(-1e-3).force_n), 0.0);
      EXPECT_EQ(pressed.breaks, 0);
    }
  }
}

TEST(ElasticLevel, BreaksWhereItsStrengthIsReached) {
  for (const double stiffness : {150.0, 1000.0}) {
    for (const double strength : {0.4, 1.5}) {
      Pressed pressed(ball({{.value = 0.0, .strength_n = strength, .stiffness_n_per_m = stiffness}}));
      const double deepest_m = strength / in_series(stiffness);
      EXPECT_NEAR(norm(pressed.to(0.999 * deepest_m).force_n), 0.999 * strength, 1e-6);
      EXPECT_EQ(pressed.breaks, 0);
      EXPECT_EQ(norm(pressed.to(1.001 * deepest_m).force_n), 0.0);
      EXPECT_EQ(pressed.breaks, 1);
      EXPECT_EQ(pressed.onsets, 1);
      EXPECT_EQ(norm(pressed.to(-1e-3).force_n), 0.0) << "nothing holds on the way out";
      EXPECT_NEAR(norm(pressed.to(0.5 * deepest_m).force_n), 0.5 * strength, 1e-6) << "and it is there again";
    }
  }
}

TEST(ElasticLevel, IsFeltThroughByOneBelow) {
  const double soft = 200.0, below_m = 4e-3;
  Pressed pressed(ball({{.value = 0.0, .strength_n = 3.0, .stiffness_n_per_m = soft}, {.value = below_m, .strength_n = 6.0}}));
  const double met_m = below_m * soft / in_series(soft);  // there the proxy meets the second
  EXPECT_NEAR(norm(pressed.to(0.99 * met_m).force_n), 0.99 * soft * below_m, 1e-6);
  EXPECT_EQ(pressed.onsets, 1);
  for (const double deeper_m : {0.5e-3, 1.5e-3, 2.5e-3}) {
    const Tick tick = pressed.to(met_m + deeper_m);
    EXPECT_NEAR(norm(tick.force_n), soft * below_m + k * deeper_m, 1e-5) << "rigid below";
    EXPECT_NEAR(radius_m - norm(tick.proxy_m), below_m, 1e-8);
  }
  EXPECT_EQ(pressed.onsets, 2);
  EXPECT_NEAR(norm(pressed.to(0.5 * met_m).force_n), 0.5 * soft * below_m, 1e-6) << "the same on the way back";
  EXPECT_EQ(norm(pressed.to(-1e-3).force_n), 0.0);
  EXPECT_EQ(pressed.breaks, 0);
}

TEST(ElasticLevel, OneBelowBreaksByItself) {
  const double soft = 200.0, below_m = 4e-3;
  Pressed pressed(ball({{.value = 0.0, .strength_n = 5.0, .stiffness_n_per_m = soft}, {.value = below_m, .strength_n = 1.0}}));
  const double met_m = below_m * soft / in_series(soft);
  pressed.to(met_m + 0.99 / k);
  EXPECT_EQ(pressed.breaks, 0);
  const Tick tick = pressed.to(met_m + 1.01 / k);
  EXPECT_EQ(pressed.breaks, 1);
  EXPECT_NEAR(norm(tick.force_n), in_series(soft) * pressed.depth_m, 1e-6) << "the soft one still bears";
}

TEST(ElasticLevel, LeadsRoundASphereWithoutDrift) {
  for (const bool as_grid : {false, true}) {
    const double stiffness = 300.0, depth_m = 3e-3;
    Session session(ball({{.value = 0.0, .strength_n = 5.0, .stiffness_n_per_m = stiffness}}, as_grid));
    const double speed = 0.2;
    const int per_turn = static_cast<int>(2 * std::numbers::pi * radius_m / (speed * dt));
    const double felt_n = in_series(stiffness) * depth_m;
    for (int i = -per_turn / 4; i <= 3 * per_turn; ++i) {
      const double a = 2 * std::numbers::pi * i / per_turn, r = radius_m - (i < 0 ? 8.0 * i / per_turn + 1.0 : 1.0) * depth_m;
      const Tick tick = session.tick({.position_m = r * Vec3{std::sin(a), 0, std::cos(a)}}, dt);
      EXPECT_EQ(tick.status, TickStatus::complete);
      if (i < per_turn / 8) continue;
      EXPECT_NEAR(norm(tick.force_n), felt_n, as_grid ? 0.01 * felt_n : 1e-6);
      // A step is settled below a further move of 5e-4 of a spacing: the permitted turn of a force of this length.
      EXPECT_NEAR(dot(normalized(tick.force_n), Vec3{std::sin(a), 0, std::cos(a)}), 1.0, as_grid ? 1e-4 : 5e-7);
    }
  }
}

TEST(ElasticLevel, StoresWhatItTakesAndGivesItBack) {
  const double stiffness = 250.0, depth_m = 5e-3;
  Pressed pressed(ball({{.value = 0.0, .strength_n = 5.0, .stiffness_n_per_m = stiffness}}));
  const Tick tick = pressed.to(depth_m);
  const double force_n = in_series(stiffness) * depth_m;
  EXPECT_NEAR(tick.energy.elastic_j, 0.5 * force_n * force_n / stiffness, 1e-9);
  EXPECT_NEAR(tick.energy.stored_j, 0.5 * force_n * force_n / k, 1e-9);
  EXPECT_EQ(pressed.to(-1e-3).energy.elastic_j, 0.0);
}

// For any hand: no level, elastic or not, injects energy, and the hand's work is conserved.
TEST(ElasticLevel, BringsNothingIn) {
  test::Random random(7);
  for (int run = 0; run < 40; ++run) {
    const bool as_grid = run % 2;
    double strengths_n = 0.0;
    std::vector<Level> levels;
    for (int i = 0; i < 1 + run % 4; ++i) {
      levels.push_back({.name = "level" + std::to_string(i), .value = 0.003 * i, .strength_n = random.uniform(0.5, 4.0)});
      if (i < 3) levels.back().stiffness_n_per_m = random.uniform(50, 2000);
      strengths_n += levels.back().strength_n.constant_n;
    }
    Session session(ball(levels, as_grid, run % 3 == 0 ? 0.4 : 0.0));
    const test::Wander hand(random, 0.06);
    Vec3 probe_before, force_before;
    double before_j = 0.0;
    for (int i = 0; i < 3000; ++i) {
      const Vec3 probe = hand.at(i * dt);
      const Tick tick = session.tick({.position_m = probe}, dt);
      ASSERT_TRUE(is_finite(tick.force_n));
      const Energy& energy = tick.energy;
      const double rounding_j = 1e-9 + 2e-5 * (energy.stored_j + energy.elastic_j + before_j);
      if (i > 0) {
        // A force of the tick's end along the chord of its footing's arc.
        const double footing_step_m = norm(probe - probe_before) * radius_m / std::min(norm(probe), norm(probe_before));
        EXPECT_LE(energy.injected_j, 1e-10 + strengths_n * footing_step_m * footing_step_m / (2 * radius_m))
            << run << ", " << i;
        const double now_j = energy.stored_j + energy.elastic_j;
        EXPECT_LE(dot(force_before, probe - probe_before),
                  before_j - now_j + 0.5 * k * norm_squared(probe - probe_before) + rounding_j)
            << run << ", " << i;
        const double right_j = before_j - now_j + 0.5 * k * norm_squared(probe - probe_before) + energy.injected_j -
                               energy.dissipated_j + energy.path_and_release_j + energy.data_motion_j;
        EXPECT_NEAR(dot(force_before, probe - probe_before), right_j, 1e-12 + 1e-9 * before_j);
      }
      before_j = energy.stored_j + energy.elastic_j;
      force_before = tick.force_n;
      probe_before = probe;
    }
  }
}

// Folded data, with a footing between two walls of a groove: at most the level's strength, with its friction and the tick's own
// part.
TEST(ElasticLevel, NeverHoldsMoreThanItBearsWhereItFolds) {
  constexpr double strength_n = 1.0, friction = 0.2;
  test::Random random(9);
  for (int round = 0; round < 4; ++round) {
    constexpr int n = 40;
    auto values = std::make_shared<std::vector<float>>();
    for (int i = 0; i < n * n * n; ++i) values->push_back(static_cast<float>(random.uniform(-1.0, 1.0)));
    const double step_m = 0.1 / (n - 1);
    const GridGeometry geometry{{n, n, n}, {{{step_m, 0, 0}, {0, step_m, 0}, {0, 0, step_m}}}, {-0.05, -0.05, -0.05}};
    Volume volume;
    volume.fields = {{"noise", "", smooth_grid_field(geometry, {VoxelType::float32, 1, {values, values->data()}})}};
    Scene scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.0});
    scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
    scene.add("folds", SurfaceAndFriction{
                           .field = scene.add("data", volume),
                           .levels = {{.value = 0.1, .strength_n = strength_n, .stiffness_n_per_m = round % 2 ? 150.0 : 600.0}},
                           .friction_coefficient = round < 2 ? 0.0 : friction});
    Session session(scene);
    const test::Wander hand(random, 0.04);
    double most_n = 0.0;
    int felt = 0;
    Vec3 before = hand.at(0.0);
    for (int i = 0; i < 20000; ++i) {
      const Vec3 now = hand.at(i * dt);
      const Tick tick = session.tick({.position_m = now}, dt);
      most_n = std::max(most_n, norm(tick.force_n) - k * distance(now, before));
      felt += norm(tick.force_n) > 0.1;
      before = now;
    }
    EXPECT_LE(most_n, (1.0 + friction) * strength_n) << round;
    EXPECT_GT(felt, 2000);
  }
}

TEST(ElasticLevel, BecomesRigidAsItsStiffnessGrows) {
  test::Random random(3);
  const test::Wander hand(random, 0.06);
  double before_n = 1.0;
  for (const double stiffness : {1e4, 1e5, 1e6}) {
    Session soft(ball({{.value = 0.0, .strength_n = 4.0, .stiffness_n_per_m = stiffness}}));
    Session rigid(ball({{.value = 0.0, .strength_n = 4.0}}));
    double worst_n = 0.0;
    for (int i = 0; i < 4000; ++i) {
      const Probe probe{.position_m = hand.at(i * dt)};
      const Tick a = soft.tick(probe, dt), b = rigid.tick(probe, dt);
      // Not where one of the two has yielded a moment before the other.
      if (norm(a.force_n) > 0.0 && norm(b.force_n) > 0.0) worst_n = std::max(worst_n, norm(a.force_n - b.force_n));
    }
    EXPECT_LT(worst_n, before_n);
    EXPECT_LT(worst_n, 2.5 * 4.0 * k / stiffness) << stiffness;
    before_n = worst_n;
  }
}

}  // namespace elastic_level_test
}  // namespace palpa
