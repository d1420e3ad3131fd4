// Surfaces at the end of data: forces borne by strengths, and no weaker than the data require.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "palpa/data/grid.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace border_test {

constexpr double dt_s = 1e-3, k = 500.0, voxel_m = 1e-3;
constexpr std::int64_t n = 64;
// From the middle of the grid to the planes of its last voxels.
constexpr double half_m = 0.5 * (n - 1) * voxel_m;

using Values = std::function<double(const Vec3&)>;

Volume sampled(const Values& value_at, Filter filter) {
  const auto values = std::make_shared<std::vector<float>>();
  for (std::int64_t c = 0; c < n; ++c) {
    for (std::int64_t b = 0; b < n; ++b) {
      for (std::int64_t a = 0; a < n; ++a) {
        const Vec3 x_m{static_cast<double>(a) * voxel_m - half_m, static_cast<double>(b) * voxel_m - half_m,
                       static_cast<double>(c) * voxel_m - half_m};
        values->push_back(static_cast<float>(value_at(x_m)));
      }
    }
  }
  const GridGeometry geometry{{n, n, n}, {{{voxel_m, 0, 0}, {0, voxel_m, 0}, {0, 0, voxel_m}}}, {-half_m, -half_m, -half_m}};
  const Voxels voxels{VoxelType::float32, 1, {values, values->data()}};
  Volume volume;
  volume.fields.push_back(
      {"ct", "", filter == Filter::smooth ? smooth_grid_field(geometry, voxels) : grid_field(geometry, voxels)});
  return volume;
}

Scene scene_of(const Values& value_at, Filter filter = Filter::smooth) {
  Scene scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.0, .max_force_n = 20.0});
  scene.add("ct", sampled(value_at, filter));
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  return scene;
}

constexpr double skin_n = 0.8, bone_n = 1.7, held_n = 0.05, drag_ns_per_m = 1.0, friction = 0.1;

/// A scanned head, soft over hard and hollow, cut off on its sides.
double head(const Vec3& x_m) {
  const double r_m = norm(x_m - Vec3{0.0, 0.022, 0.0});
  const auto ramp = [&](double at_m) { return std::clamp((at_m - r_m) / (3.0 * voxel_m) + 0.5, 0.0, 1.0); };
  return -1000.0 + 1050.0 * ramp(0.028) + 1200.0 * (ramp(0.022) - ramp(0.015));
}

/// As in a first scene of a CT.
Scene cut_off_head(bool has_elastic_skin) {
  Scene scene = scene_of(head);
  SurfaceAndFriction surface{.field = {"ct"},
                             .levels = {{.name = "skin", .value = -300.0, .strength_n = skin_n},
                                        {.name = "bone", .value = 300.0, .strength_n = bone_n}},
                             .friction_coefficient = friction};
  if (has_elastic_skin) surface.levels[0].stiffness_n_per_m = 300.0;
  scene.add("surface", surface);
  scene.add("inside", Viscosity{.field = {"ct"}, .strength_n = held_n, .drag_ns_per_m = drag_ns_per_m});
  return scene;
}

struct Felt {
  double beyond_n = -1e9;  ///< above all strengths and the drag of the proxy's speed
  double unborne_n = 0.0;  ///< absent from the last balance
  double largest_n = 0.0;
  int resting = 0;
};

void push_through(const Scene& scene, const Vec3& from_m, const Vec3& to_m, Felt& felt) {
  constexpr double speed_m_per_s = 0.025, strengths_n = (skin_n + bone_n) * (1.0 + friction) + held_n;
  Session session(scene);
  const int ticks = static_cast<int>(distance(from_m, to_m) / (speed_m_per_s * dt_s));
  Vec3 proxy_m = from_m;
  for (int i = 0; i <= ticks; ++i) {
    const Tick tick = session.tick({.position_m = from_m + static_cast<double>(i) / ticks * (to_m - from_m)}, dt_s);
    const double speed = distance(tick.proxy_m, proxy_m) / dt_s, force_n = norm(tick.force_n);
    proxy_m = tick.proxy_m;
    if (tick.status != TickStatus::complete) continue;
    ++felt.resting;
    felt.largest_n = std::max(felt.largest_n, force_n);
    felt.beyond_n = std::max(felt.beyond_n, force_n - 1.01 * strengths_n - drag_ns_per_m * speed);
    felt.unborne_n = std::max(felt.unborne_n, tick.unborne_n - 0.01 * force_n);
  }
}

// A point of 0.05 N once carried 9 N and more of still hands: the proxy was deep in a level pressed in where its strength
// fades, without a free point near by.
TEST(Border, HoldsNoProxyWithMoreThanItsStrengths) {
  for (const bool has_elastic_skin : {false, true}) {
    const Scene scene = cut_off_head(has_elastic_skin);
    Felt felt;
    for (double x_m = -0.020; x_m < 0.021; x_m += 0.004) {
      for (double below_m = 0.0003; below_m < 0.012; below_m *= 1.5) {
        const double y_m = half_m - below_m;
        push_through(scene, {x_m, y_m, 0.045}, {x_m, y_m, -0.045}, felt);
        push_through(scene, {x_m, y_m + 0.004, 0.030}, {x_m, y_m - 0.004, -0.030}, felt);
        push_through(scene, {x_m, 0.045, below_m + 0.015}, {x_m, -0.01, -0.005}, felt);
      }
    }
    EXPECT_GT(felt.resting, 500000);
    EXPECT_GT(felt.largest_n, 0.9 * bone_n) << "the bone was not met";
    EXPECT_LE(felt.beyond_n, 0.0) << "at most " << felt.largest_n << " N";
    EXPECT_LE(felt.unborne_n, 1e-3);
  }
}

/// Lowers a hand straight onto the plane z = 0 at a point, and presses `force_n` into it.
Tick press_plane(Session& session, const Vec3& at_m, double force_n, int& breaks) {
  constexpr int ticks = 400;
  Tick tick;
  for (int i = 0; i <= ticks; ++i) {
    const double z_m = 2e-3 - static_cast<double>(i) / ticks * (2e-3 + force_n / k);
    tick = session.tick({.position_m = {at_m.x, at_m.y, z_m}}, dt_s);
    for (const SessionEvent& event : session.events()) breaks += event.kind == SessionEventKind::break_through;
  }
  return tick;
}

Scene plane_with(double strength_n, Filter filter) {
  Scene scene = scene_of([](const Vec3& x_m) { return -x_m.z / voxel_m; }, filter);
  scene.add("surface",
            SurfaceAndFriction{.field = {"ct"}, .levels = {{.name = "wall", .value = 0.0, .strength_n = strength_n}}});
  return scene;
}

TEST(Border, WeakensNoSurfaceBeyondAFewSpacings) {
  for (const Filter filter : {Filter::trilinear, Filter::smooth}) {
    const Scene scene = plane_with(1.3, filter);
    for (const double voxels : {2.1, 2.5, 3.0, 5.0, 12.0}) {
      Session session(scene);
      int breaks = 0;
      const Tick tick = press_plane(session, {half_m - voxels * voxel_m, 1.3e-3, 0.0}, 1.19, breaks);
      EXPECT_NEAR(tick.force_n.z, 1.19, 1e-6) << voxels << " voxels from the border";
      EXPECT_EQ(breaks, 0);
    }
  }
}

// A level stronger than the output limit never breaks from four voxels on.
TEST(Border, LetsNoLevelGoThatIsStrongerThanWhatReachesTheHand) {
  for (const double strength_n : {5.5, 12.0, 60.0}) {
    const Scene scene = plane_with(strength_n, Filter::smooth);
    for (const double voxels : {4.1, 6.0, 22.0}) {
      Session session(scene);
      session.set_force_limit(5.0);
      int breaks = 0;
      const Tick tick = press_plane(session, {half_m - voxels * voxel_m, 1.3e-3, 0.0}, 40.0, breaks);
      EXPECT_NEAR(tick.force_n.z, 40.0, 1e-6) << strength_n << " N, " << voxels << " voxels from the border";
      EXPECT_EQ(breaks, 0);
    }
  }
}

// It ends as softly as it began, and deeper in the data than its end a hand meets it again.
TEST(Border, FadesWithoutAKickOrABreak) {
  for (const double strength_n : {1.3, 3.3, 60.0}) {
    const Scene scene = plane_with(strength_n, Filter::smooth);
    Session session(scene);
    session.set_force_limit(3.3);
    int breaks = 0;
    const double begin_m = half_m - 0.010, force_n = 1.19, speed_m_per_s = 0.05;
    Vec3 last_n = press_plane(session, {begin_m, 1.3e-3, 0.0}, force_n, breaks).force_n;
    double steepest_n = 0.0;
    for (int i = 0; i < 600; ++i) {
      const double offset_m = (i < 300 ? i : 600 - i) * speed_m_per_s * dt_s;
      const Tick tick = session.tick({.position_m = {begin_m + offset_m, 1.3e-3, -force_n / k}}, dt_s);
      for (const SessionEvent& event : session.events()) breaks += event.kind == SessionEventKind::break_through;
      if (i < 300) steepest_n = std::max(steepest_n, distance(tick.force_n, last_n));
      last_n = tick.force_n;
    }
    EXPECT_LE(steepest_n, 0.1) << strength_n << " N";
    EXPECT_EQ(breaks, 0) << strength_n;
    // It was lifted out on its way; from outside it is unchanged.
    EXPECT_NEAR(press_plane(session, {begin_m, 1.3e-3, 0.0}, force_n, breaks).force_n.z, force_n, 1e-6);
  }
}

// A hand at rest keeps its force, at a border and beside it, on an edge that folds inwards and in a head, where the fade once
// let it creep for seconds, in hundreds of snaps.
TEST(Border, KeepsTheForceOfAHandAtRest) {
  test::Random random(45);
  Scene groove = scene_of([](const Vec3& x_m) { return (std::abs(x_m.x) - x_m.z) / voxel_m; });
  groove.add("surface", SurfaceAndFriction{.field = {"ct"}, .levels = {{.name = "wall", .value = 0.0, .strength_n = 12.0}}});
  const Scene scenes[] = {groove, cut_off_head(false), cut_off_head(true)};
  int felt = 0;
  for (int run = 0; run < 240; ++run) {
    const int which = run % 3;
    Session session(scenes[which]);
    session.set_force_limit(5.0);
    const double below_m = run % 2 == 0 ? 0.022 : random.uniform(0.0, 0.006), away = random.uniform(-1.0, 1.0);
    const Vec3 from_m = which == 0 ? Vec3{1e-3 * away, half_m - below_m, 0.008} : Vec3{0.020 * away, half_m - below_m, 0.045};
    const Vec3 to_m = from_m + (which == 0 ? random.uniform(0.009, 0.016) : random.uniform(0.01, 0.06)) *
                                   normalized(Vec3{0.1 * random.uniform(-1, 1), 0.3 * random.uniform(-1, 1), -1.0});
    Tick tick;
    Vec3 low_n{1e9, 1e9, 1e9}, high_n = -low_n;
    for (int i = 0; i < 1300; ++i) {
      tick = session.tick({.position_m = from_m + std::min(1.0, i / 200.0) * (to_m - from_m)}, dt_s);
      if (i < 300) continue;
      const Vec3& f = tick.force_n;
      low_n = {std::min(low_n.x, f.x), std::min(low_n.y, f.y), std::min(low_n.z, f.z)};
      high_n = {std::max(high_n.x, f.x), std::max(high_n.y, f.y), std::max(high_n.z, f.z)};
    }
    felt += norm(tick.force_n) > 0.1;
    EXPECT_LE(norm(high_n - low_n), 1e-3) << run << ": " << norm(low_n) << " N to " << norm(high_n) << " N";
  }
  EXPECT_GT(felt, 60);
}

// The footing of an elastic level is beside the proxy: at a cut-off edge that folds inwards it once left the data, its level
// was lost and met again up to ten times a tick, and up to 0.8 N of a hand at rest were borne by nothing.
TEST(Border, KeepsTheFootingsOfElasticLevelsInTheData) {
  test::Random random(54);
  int felt = 0, resting = 0, unborne = 0;
  for (int run = 0; run < 80; ++run) {
    const Vec3 first = random.direction(), second = random.direction();
    const Vec3 on_edge_m{random.uniform(-0.01, 0.01), half_m - random.uniform(-0.01, 0.02), random.uniform(-0.01, 0.01)};
    Scene scene = scene_of(
        [&](const Vec3& x_m) { return -std::min(dot(first, x_m - on_edge_m), dot(second, x_m - on_edge_m)) / voxel_m; });
    scene.edit<CouplingOptions>([&](auto& coupling) { coupling.stiffness_n_per_m = random.uniform(300.0, 1800.0); });
    SurfaceAndFriction surface{.field = {"ct"}, .levels = {{.name = "wall", .value = 0.0, .strength_n = 3.0}}};
    surface.levels[0].stiffness_n_per_m = random.uniform(150.0, 600.0);
    scene.add("surface", surface);
    if (run % 2 == 0) scene.add("inside", Viscosity{.field = {"ct"}, .strength_n = held_n, .drag_ns_per_m = drag_ns_per_m});
    for (int way = 0; way < 4; ++way) {
      const double below_m = random.uniform(-0.0005, 0.006), side = way % 2 == 0 ? 1.0 : -1.0;
      const Vec3 from_m{side * 0.035, half_m - below_m, random.uniform(-0.02, 0.02)};
      const int moves = static_cast<int>(random.uniform(800.0, 2800.0));
      Session session(scene);
      Vec3 low_n{1e9, 1e9, 1e9}, high_n = -low_n;
      for (int i = 0; i < moves + 400; ++i) {
        const Tick tick = session.tick({.position_m = from_m - Vec3{side * 0.025 * dt_s * std::min(i, moves), 0, 0}}, dt_s);
        const Vec3& f = tick.force_n;
        felt += norm(f) > 0.1;
        if (tick.status != TickStatus::complete) continue;
        ++resting;
        unborne += tick.unborne_n > 0.01 * norm(f) + 1e-3;
        if (i < moves + 200) continue;
        EXPECT_LE(tick.unborne_n, 0.01 * norm(f) + 1e-3) << run << ": a hand at rest";
        low_n = {std::min(low_n.x, f.x), std::min(low_n.y, f.y), std::min(low_n.z, f.z)};
        high_n = {std::max(high_n.x, f.x), std::max(high_n.y, f.y), std::max(high_n.z, f.z)};
      }
      EXPECT_LE(norm(high_n - low_n), 1e-3) << run << ": a hand at rest";
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(felt, 50000);
  // A tick in which a level is met or lost may end beside its balance.
  EXPECT_LE(unborne, 1e-4 * resting);
}

}  // namespace border_test
}  // namespace palpa
