// Laws of tools beyond those by which the path was made: chamfers, hooks, saddles, moving and noisy data, late orientations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "palpa/data/grid.h"
#include "palpa/data/timed_field.h"
#include "tests/path/tools.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace tools_held_out_test {

using namespace tools_test;
using test::Random;

// Smallest argument of a convex function on [low, high], to rounding of its values.
template <class Function>
double argument_of_least(double low, double high, const Function& f) {
  for (int i = 0; i < 200; ++i) {
    const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
    (f(a) < f(b) ? high : low) = f(a) < f(b) ? b : a;
  }
  return 0.5 * (low + high);
}

// Rings of eight feet about z, one foot of each in the direction of x.
std::vector<Vec3> rings(double radius_m, std::initializer_list<double> at_z_m) {
  std::vector<Vec3> feet;
  for (const double z_m : at_z_m) {
    for (int i = 0; i < 8; ++i)
      feet.push_back({radius_m * std::cos(i * std::numbers::pi / 4), radius_m * std::sin(i * std::numbers::pi / 4), z_m});
  }
  return feet;
}

// ---- shapes ----

// A block below z = 0 with a hole along z, whose mouth is a cone of 45° of this depth; depth 0: a sharp edge.
FieldPtr hole_with_chamfer(double radius_m, double chamfer_m) {
  return formula(
      [=](const Vec3& x_m) {
        const Vec3 across{x_m.x, x_m.y, 0.0};
        const double from_axis_m = norm(across);
        const Vec3 outwards = from_axis_m > 0.0 ? across / from_axis_m : Vec3{};
        ScalarSample sample{-x_m.z, {0, 0, -1}, true};
        if (from_axis_m - radius_m < sample.value) sample = {from_axis_m - radius_m, outwards, true};
        const double in_cone_m = std::sqrt(0.5) * (from_axis_m - radius_m - chamfer_m - x_m.z);
        if (in_cone_m < sample.value) sample = {in_cone_m, std::sqrt(0.5) * (outwards - Vec3{0, 0, 1}), true};
        return sample;
      },
      0.8, 1e-3);
}

// A peg beside its hole slides down the chamfer and in; onto a sharp edge it stands.
TEST(ToolsHeldOut, APegFindsItsHoleByTheChamfer) {
  const double R = 0.005, r = 0.0045, aside_m = 0.002;
  const ToolOptions peg = points(rings(r, {-0.015, 0.0, 0.015}));
  for (const double chamfer_m : {0.003, 0.0}) {
    const FieldPtr solid = hole_with_chamfer(R, chamfer_m);
    const Scene scene = tool_scene(solid, peg, {.kappa = 5.0});
    const Tool tool(scene.tool(), scene.coupling());
    Session session(scene);
    const double from_m = 0.02, to_m = chamfer_m > 0.0 ? -0.025 : 0.013;
    Tick tick;
    for (int i = 0; i <= 2000; ++i) {
      const double share = std::min(1.0, i / 1500.0);
      tick = felt(session, {{aside_m, 0, from_m + share * (to_m - from_m)}, {}});
      ASSERT_LE(deepest_m(*solid, tool, tick), 1e-5) << i;
    }
    if (chamfer_m > 0.0) {
      EXPECT_NEAR(tick.proxy_m.z, to_m, 1e-6) << "without friction it is in as deep as the hand";
      EXPECT_NEAR(tick.force_n.x, k * (R - r - aside_m), 1e-4);
      EXPECT_NEAR(norm(tick.torque_nm), 0.0, 1e-5);
    } else {
      EXPECT_GT(tick.proxy_m.z, 0.0149);
      EXPECT_GT(tick.force_n.z, 0.9 * k * 0.002);
    }
  }
}

// A foot above a plane whose device is below it: turned, its arc bends into the solid. The tool rises and lags as the exact
// minimum of both springs says.
TEST(ToolsHeldOut, AHookThatIsTurnedRisesOutOfTheSolid) {
  const double b = 0.06, gap_m = 0.001;
  for (const double kappa : {0.5, 5.0}) {
    for (const double asked_rad : {0.1, 0.3, 0.8}) {
      const FieldPtr solid = plane();
      const Scene scene = tool_scene(solid, points({{0, b, 0}}), {.kappa = kappa});
      const Tool tool(scene.tool(), scene.coupling());
      Session session(scene);
      const Pose from{{0, gap_m - b, 0}, {}};
      Tick tick;
      for (int i = 0; i <= 1000; ++i) {
        tick = felt(session, {from.position_m, turn_by({0, 0, asked_rad * std::min(1.0, i / 500.0)})});
        ASSERT_LE(deepest_m(*solid, tool, tick), 1e-5) << i;
      }
      const auto rise_m = [&](double angle) { return std::max(0.0, b - gap_m - b * std::cos(angle)); };
      const double angle = argument_of_least(0.0, asked_rad, [&](double a) {
        return 0.5 * k * rise_m(a) * rise_m(a) + 0.5 * kappa * (asked_rad - a) * (asked_rad - a);
      });
      EXPECT_NEAR(tilt_rad(tick).z, angle, 1e-5) << kappa << " " << asked_rad;
      EXPECT_NEAR(tick.force_n.y, k * rise_m(angle), 1e-4 + 1e-4 * k * rise_m(angle)) << kappa << " " << asked_rad;
      EXPECT_NEAR(tick.torque_nm.z, kappa * (angle - asked_rad), 1e-4) << kappa << " " << asked_rad;
    }
  }
}

// A saddle between two feet that stand where it rises: pressed, they turn towards where it falls, by the exact minimum.
TEST(ToolsHeldOut, ARodAcrossASaddleTurnsTowardsItsFall) {
  const double R = 0.05, a = 0.02, kappa = 0.5;
  const FieldPtr saddle = formula(
      [R](const Vec3& x_m) {
        return ScalarSample{(x_m.x * x_m.x - x_m.z * x_m.z) / (2.0 * R) - x_m.y, {x_m.x / R, -1.0, -x_m.z / R}, true};
      },
      0.8, 1e-3);
  for (const double asked_rad : {0.01, 0.2}) {
    for (const double depth_m : {0.001, 0.01}) {
      Session session(tool_scene(saddle, points({{-a, 0, 0}, {a, 0, 0}}), {.kappa = kappa}));
      const Turn turn = turn_by({0, asked_rad, 0});
      const Tick tick = go(session, {{0, 0.01, 0}, turn}, {{0, -depth_m, 0}, turn}, 400);
      const auto height_m = [&](double angle) { return a * a * std::cos(2.0 * angle) / (2.0 * R); };
      const double angle = argument_of_least(asked_rad, 0.7, [&](double at) {
        return 0.5 * k * std::pow(height_m(at) + depth_m, 2) + 0.5 * kappa * std::pow(at - asked_rad, 2);
      });
      EXPECT_NEAR(tilt_rad(tick).y, angle, 1e-4) << asked_rad << " " << depth_m;
      EXPECT_NEAR(tick.force_n.y, k * (height_m(angle) + depth_m), 1e-3) << asked_rad << " " << depth_m;
      EXPECT_LT(std::hypot(tilt_rad(tick).x, tilt_rad(tick).z), 1e-5);
    }
  }
}

// ---- data that move ----

Scene moving_plane(const PoseTrack& track, ToolOptions tool, double friction_n) {
  Scene scene =
      test::plain_scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.0, .max_force_n = 100.0, .max_torque_nm = 10.0});
  const FieldRef solid = scene.add_moving("solid", test::volume_of(plane()), track);
  scene.add("surface",
            SurfaceAndFriction{
                .field = solid, .levels = {{.name = "skin", .value = 0.0, .strength_n = strong_n}}, .friction_n = friction_n});
  tool.turning_radius_m = ToolSetting{}.radius_m();
  scene.set(tool);
  scene.edit<TimeOptions>([](TimeOptions& time) { time.play = TimeOptions::Play::once; });
  return scene;
}

// A hand that goes and turns with the data feels what a hand on still data does, with its axes. Feet that stick are led apart
// by their chords, |ω|²b/2 a tick, so that of several one slips by as much.
TEST(ToolsHeldOut, MovingTogetherWithDataFeelsAsAtRest) {
  const double seconds = 0.5;
  const ToolOptions one = points({{0.01, -0.02, 0.005}}), two = points({{0.01, 0, 0}, {-0.01, 0, 0}});
  for (const Vec3& axis_rad : {Vec3{}, Vec3{0.0, -0.9, 0.0}, Vec3{0.5, 0.4, -0.9}}) {
    const PoseTrack track{{0.0, {}}, {seconds, {matrix_of(turn_by(axis_rad)), 1.0, {0.03, -0.02, 0.01}}}};
    for (const double friction_n : {0.0, 0.3}) {
      for (const auto& options : {one, two, pad(0.01, 8), friction_n > 0.0 ? rod(0.04, 2) : rod(0.04, 8)}) {
        const Scene scene = moving_plane(track, options, friction_n);
        const Tool tool(scene.tool(), scene.coupling());
        Scene still = scene;
        still.edit<TimeOptions>([](TimeOptions& time) { time.play = TimeOptions::Play::hold; });
        Session session(scene), resting(still);
        const double slip_m =
            friction_n > 0.0 && tool.feet() > 1 ? 0.5 * norm_squared(dt / seconds * axis_rad) * tool.reach_m() : 0.0;
        Vec3 first_n, first_nm;
        for (int i = 0; i < 480; ++i) {
          const double share = std::min(1.0, i / 100.0), t = (i + 1) * dt;
          const Pose in_data{{0.004 * share, 0.03 - 0.035 * share, 0.002 * share}, turn_by({0.05 * share, 0.03 * share, 0.0})};
          const Turn data = turn_by(t / seconds * axis_rad);
          const Pose device{pose_at(track, t).to_world(in_data.position_m), data * in_data.turn};
          const Tick moved = felt(session, device), rested = felt(resting, in_data);
          if (i < 200) continue;
          const Vec3 force_n = rotated(inverse(data), moved.force_n), torque_nm = rotated(inverse(data), moved.torque_nm);
          if (i == 200) first_n = force_n, first_nm = torque_nm;
          const double slipped_n = 2.0 * k * slip_m * (i - 200);
          ASSERT_GT(norm(force_n), 0.5);
          ASSERT_LT(norm(force_n - first_n), slipped_n + 2e-5) << i << " friction " << friction_n << " " << norm(axis_rad);
          ASSERT_LT(norm(torque_nm - first_nm), slipped_n * 0.5 / (k * tool.reach_m()) + 3e-6)
              << i << " friction " << friction_n;
          if (friction_n > 0.0) continue;
          ASSERT_LT(norm(force_n - rested.force_n), 1e-5) << i;
          ASSERT_LT(norm(torque_nm - rested.torque_nm), 1e-4) << i;
        }
      }
    }
  }
}

// Turned under a still hand, a plane carries the ring until its friction slips: κ times the turn, then N s r.
TEST(ToolsHeldOut, APlaneThatTurnsUnderARingTwistsTheHand) {
  const double r = 0.01, s = 0.1, kappa = 0.5, rate_rad_per_s = 0.2, seconds = 1.0;
  std::vector<Vec3> ring;
  for (int i = 0; i < 8; ++i)
    ring.push_back({r * std::cos(i * std::numbers::pi / 4), 0, r * std::sin(i * std::numbers::pi / 4)});
  const PoseTrack track{{0.0, {}}, {seconds, {matrix_of(turn_by({0, rate_rad_per_s * seconds, 0})), 1.0, {}}}};
  Session session(moving_plane(track, points(ring), s));
  double stuck_from_s = -1.0;
  double data_motion_j = 0.0, dissipated_j = 0.0;
  for (int i = 0; i < 990; ++i) {
    const double share = std::min(1.0, i / 20.0), t = (i + 1) * dt;
    const Tick tick = felt(session, {{0, 0.001 - 0.005 * share, 0}, {}});
    data_motion_j += tick.energy.data_motion_j, dissipated_j += tick.energy.dissipated_j;
    if (i < 40) continue;
    if (stuck_from_s < 0.0) stuck_from_s = t - tick.torque_nm.y / (kappa * rate_rad_per_s);
    const double stuck_nm = kappa * rate_rad_per_s * (t - stuck_from_s);
    ASSERT_NEAR(tick.torque_nm.y, std::min(8 * s * r, stuck_nm), 2e-5) << i;
    ASSERT_NEAR(tick.force_n.y, k * 0.004, 1e-6) << i;
    ASSERT_LT(std::hypot(tick.force_n.x, tick.force_n.z), 1e-4) << i;
  }
  EXPECT_GT(data_motion_j, 0.8 * 8 * s * r * rate_rad_per_s * 0.85);
  EXPECT_GT(dissipated_j, 0.8 * 8 * s * r * rate_rad_per_s * 0.85);
}

// A wall of a time series pushes a rod that lies flat on it as it pushes a point.
TEST(ToolsHeldOut, ASeriesOfFramesPushesARodAsAPoint) {
  std::vector<FieldPtr> frames;
  constexpr int n = 61, count = 20;
  for (int frame = 0; frame < count; ++frame) {
    const double wall_m = 2e-3 * std::sin(2.0 * std::numbers::pi * frame / count);
    auto values = std::make_shared<std::vector<float>>();
    for (int at = 0; at < n; ++at)
      values->insert(values->end(), n * n, static_cast<float>(std::tanh((wall_m - (at - n / 2) * 1e-3) / 4e-3)));
    frames.push_back(grid_field(test::cube_of(n, 1e-3), {VoxelType::float32, 1, {values, values->data()}}));
  }
  Scene scene = test::plain_scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.0, .max_force_n = 100.0});
  const FieldRef wall = scene.add("wall", test::volume_of(time_series(frames, 0.05), ""));
  scene.add("skin", SurfaceAndFriction{.field = wall, .levels = {{.name = "skin", .value = 0.0, .strength_n = strong_n}}});
  scene.set(TimeOptions{TimeOptions::Play::loop, 1.0, 0.0});
  Session point(scene);
  scene.set(points({{-0.01, 0, 0}, {0, 0.01, 0}, {0.01, -0.01, 0}}));
  Session rests(scene);
  double most_n = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 hand{0.0013, -0.0021, 0.005 - 0.006 * std::min(1.0, i / 200.0)};
    const Tick one = felt(point, {hand, {}}), many = felt(rests, {hand, {}});
    ASSERT_LT(norm(one.force_n - many.force_n), 2e-3) << i;
    ASSERT_LT(norm(many.torque_nm), 2e-5) << i;
    most_n = std::max(most_n, norm(many.force_n));
  }
  EXPECT_GT(most_n, 1.0);
}

// ---- orientation ----

// Held by friction at all its feet, a tool is twisted by 170° and back: κ times the stretch, no force, and no energy left over.
TEST(ToolsHeldOut, StretchedBy170DegreesBetweenFeetThatStick) {
  const double r = 0.02, s = 20.0, kappa = 0.5, most_rad = 170.0 / 180.0 * std::numbers::pi;
  std::vector<Vec3> ring;
  for (int i = 0; i < 8; ++i)
    ring.push_back({r * std::cos(i * std::numbers::pi / 4), 0, r * std::sin(i * std::numbers::pi / 4)});
  Session session(tool_scene(plane(), points(ring), {.kappa = kappa, .friction_n = s}));
  Tick before = go(session, {{0, 0.002, 0}, {}}, {{0, -0.004, 0}, {}}, 100);
  double work_j = 0.0, hold_j = 0.0;
  constexpr int ticks = 1500;
  for (int i = 1; i <= 2 * ticks; ++i) {
    const double angle = most_rad * (i <= ticks ? i : 2 * ticks - i) / ticks;
    const Tick tick = felt(session, {{0, -0.004, 0}, turn_by({0, angle, 0})});
    ASSERT_NEAR(tick.torque_nm.y, -kappa * angle, 1e-4) << i;
    ASSERT_LT(norm(tick.force_n - Vec3{0, k * 0.004, 0}), 1e-4) << i;
    work_j += dot(before.torque_nm, tick.probe_turn_step_rad);
    hold_j += 0.5 * kappa * norm_squared(tick.probe_turn_step_rad);
    before = tick;
  }
  EXPECT_LE(work_j, hold_j + 1e-6);
  EXPECT_GE(work_j, -hold_j - 1e-6) << "a spring, without a loss";
}

// An orientation that comes at 50 Hz: each step of the turn is a step of the force within the spring's, and nothing follows it.
TEST(ToolsHeldOut, AnOrientationAt50HzStepsByTheSpringAndIsQuietBetween) {
  constexpr int each = 20;  // [ticks] of 1 kHz
  const double step_rad = 0.01, kappa = 0.5, rho = ToolSetting{}.radius_m();
  struct Case {
    FieldPtr solid;
    ToolOptions tool;
    Vec3 at_m, axis;
  };
  for (const double friction_n : {0.0, 0.1}) {
    for (const Case& given :
         {Case{plane(), points({{0.06, 0, 0}}), {0, -0.003, 0}, {0, 0, -1}},
          Case{ball(0.05), rod(0.04, 8), {0, 0.046, 0}, {1, 0, 0}}, Case{hole(0.002), rod(0.04, 8), {0.0005, 0, 0}, {1, 0, 0}},
          Case{ball(0.05), pad(0.01, 16), {0.005, 0.047, 0}, {0, 0, 1}}}) {
      const Scene scene = tool_scene(given.solid, given.tool, {.kappa = kappa, .friction_n = friction_n});
      const Tool tool(scene.tool(), scene.coupling());
      Session session(scene);
      Tick before = go(session, {given.at_m + Vec3{0, given.at_m.x > 0.0 && given.at_m.y == 0.0 ? 0.0 : 0.01, 0}, {}},
                       {given.at_m, {}}, 100);
      double work_j = 0.0, hold_j = 0.0;
      for (int i = 0; i < 60 * each; ++i) {
        const int steps = i / each + 1, turned = steps <= 30 ? steps : 60 - steps;
        const Tick tick = felt(session, {given.at_m, turn_by(turned * step_rad * given.axis)});
        const double force_step_n = norm(tick.force_n - before.force_n),
                     torque_step_nm = norm(tick.torque_nm - before.torque_nm);
        const bool stepped = i % each == 0;
        // A balance moves no further than its device, in the metric: k ρ a radian of turn; and what a snap of friction frees.
        const double most_n = 1.2 * k * std::max(rho, tool.reach_m()) * step_rad + 2.0 * friction_n;
        if (stepped) {
          ASSERT_LE(force_step_n, most_n) << i << " of " << tool.feet();
          ASSERT_LE(torque_step_nm, 1.2 * kappa * step_rad + most_n * tool.reach_m()) << i << " of " << tool.feet();
        } else if (i % each > 5) {
          ASSERT_LE(force_step_n, 1e-3) << i << " of " << tool.feet() << " friction " << friction_n;
          ASSERT_LE(torque_step_nm, 5e-5) << i << " of " << tool.feet() << " friction " << friction_n;
        }
        work_j += dot(before.torque_nm, tick.probe_turn_step_rad);
        hold_j += 0.5 * kappa * norm_squared(tick.probe_turn_step_rad);
        before = tick;
      }
      EXPECT_LE(work_j, hold_j + 1e-6) << "there and back brings in no more than the hold";
    }
  }
}

// ---- data of different kinds under different feet ----

// A plane y = 0 on a grid of 1 mm, with noise of a voxel's height where x < 0.
FieldPtr half_noisy_plane(Random& random, double noise_m) {
  constexpr int n = 81;
  auto values = std::make_shared<std::vector<float>>();
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x)
        values->push_back(static_cast<float>(-1e-3 * (y - n / 2) + (x < n / 2 ? random.uniform(-noise_m, noise_m) : 0.0)));
    }
  }
  return grid_field(test::cube_of(n, 1e-3), {VoxelType::float32, 1, {values, values->data()}});
}

TEST(ToolsHeldOut, OneFootInNoiseIsQuietUnderAStillHand) {
  Random random(11);
  double worst_n = 0.0, worst_nm = 0.0;
  for (int run = 0; run < 40; ++run) {
    const double friction_n = run % 2 == 0 ? 0.0 : 0.2;
    Session session(tool_scene(half_noisy_plane(random, 1e-3), points({{-0.015, 0, 0}, {0.015, 0, 0}}),
                               {.strength_n = run % 4 < 2 ? strong_n : 1.5, .friction_n = friction_n}));
    const Vec3 at = random.in_cube(0.005);
    const Pose from{{at.x, 0.01, at.z}, {}}, to{{at.x + 0.004, -0.003, at.z + 0.003}, turn_by(random.in_cube(0.1))};
    go(session, from, to, 100);
    const Tick first = felt(session, to);
    for (int i = 0; i < 100; ++i) {
      const Tick tick = felt(session, to);
      worst_n = std::max(worst_n, norm(tick.force_n - first.force_n));
      worst_nm = std::max(worst_nm, norm(tick.torque_nm - first.torque_nm));
      ASSERT_LT(norm(tick.force_n - first.force_n), 1e-3) << run << " " << i;
      ASSERT_LT(norm(tick.torque_nm - first.torque_nm), 5e-5) << run << " " << i;
    }
  }
  std::printf("one foot in noise, at rest: %.3g mN, %.3g mN·m\n", 1e3 * worst_n, 1e3 * worst_nm);
}

// Two volumes side by side, planes at the heights `left_m` (x < 0) and `right_m`, each with a mode of its own.
Scene two_planes(double left_m, double left_n, double right_m, double right_n, ToolOptions tool, double kappa) {
  Scene scene =
      test::plain_scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.0, .max_force_n = 100.0, .max_torque_nm = 10.0});
  const auto half = [&](const char* name, double x_m, double height_m, double strength_n) {
    const FieldPtr field = formula([](const Vec3& at_m) { return half_space(at_m, {0, 1, 0}); }, 0.2, 1e-3);
    const FieldRef ref = scene.add(name, test::volume_of(field), {Mat3::identity(), 1.0, {x_m, height_m, 0}});
    scene.add(name, SurfaceAndFriction{.field = ref, .levels = {{.name = name, .value = 0.0, .strength_n = strength_n}}});
  };
  half("left", -0.1, left_m, left_n);
  half("right", 0.1, right_m, right_n);
  tool.turning_radius_m = std::sqrt(kappa / k);
  scene.set(tool);
  return scene;
}

TEST(ToolsHeldOut, FeetOnDifferentDataTiltTheToolBetweenThem) {
  const double a = 0.02, step_m = 0.002, depth_m = 0.005, kappa = 0.5;
  Session session(two_planes(0.0, strong_n, -step_m, strong_n, points({{-a, 0, 0}, {a, 0, 0}}), kappa));
  const Tick tick = go(session, {{0, 0.01, 0}, {}}, {{0, -depth_m, 0}, {}}, 200);
  const double angle = -std::asin(step_m / (2 * a));
  EXPECT_NEAR(tilt_rad(tick).z, angle, 1e-6);
  EXPECT_NEAR(tick.force_n.y, k * (depth_m - 0.5 * step_m), 1e-4);
  EXPECT_NEAR(tick.torque_nm.z, kappa * angle, 1e-6);
  EXPECT_EQ(session.modes().size(), 2u);
  const double left_n = session.modes()[0].force_n.y, right_n = session.modes()[1].force_n.y;
  EXPECT_NEAR(left_n + right_n, tick.force_n.y, 1e-5);
  EXPECT_NEAR((right_n - left_n) * a * std::cos(angle), tick.torque_nm.z, 1e-6);
}

// The weak side breaks where the lever rule loads it with its strength, once; the other foot stays on its level.
TEST(ToolsHeldOut, OneFootBreaksThroughWhileTheOtherHolds) {
  const double a = 0.02, weak_n = 0.4, kappa = 0.5;
  Session session(two_planes(0.0, weak_n, 0.0, strong_n, points({{-a, 0, 0}, {a, 0, 0}}), kappa));
  int breaks = 0;
  double broke_at_m = 0.0;
  Tick tick;
  for (int i = 0; i < 1500; ++i) {
    const double y_m = 1e-3 - 5e-6 * i;
    tick = felt(session, {{0, y_m, 0}, {}});
    for (const SessionEvent& event : session.events()) {
      if (event.kind != SessionEventKind::break_through) continue;
      ++breaks;
      broke_at_m = -y_m;
    }
    const double right_m = tick.proxy_m.y + rotated(tick.proxy_turn, {a, 0, 0}).y;
    ASSERT_GE(right_m, -1e-6) << i;
    if (y_m < -1e-4) {
      ASSERT_LE(right_m, 1e-6) << i << ": pressed on, the strong side bears";
    }
  }
  EXPECT_EQ(breaks, 1);
  EXPECT_NEAR(broke_at_m, 2.0 * weak_n / k, 6e-6);
  // One foot across a wall: the nonlinear minimum of the stick.
  const double depth_m = -(1e-3 - 5e-6 * 1499);
  const double angle = argument_of_least(
      0.0, 1.0, [&](double at) { return 0.5 * k * std::pow(depth_m - a * std::sin(at), 2) + 0.5 * kappa * at * at; });
  EXPECT_NEAR(tick.force_n.y, k * (depth_m - a * std::sin(angle)), 1e-3);
}

// A mask that is 0 at one foot leaves what the other feet feel.
TEST(ToolsHeldOut, AMaskTakesTheFeetOutThatAreOutsideIt) {
  const double a = 0.02;
  const ToolOptions both = points({{-a, 0, 0}, {a, 0, 0}}), one = points({{a, 0, 0}});
  Scene masked = tool_scene(plane(), both);
  const FieldRef side = masked.add("side", test::volume_of(formula(
                                               [](const Vec3& x_m) {
                                                 return ScalarSample{x_m.x, {1, 0, 0}, true};
                                               },
                                               0.8, 1e-3)));
  masked.edit_mode("surface", [&](SceneMode& mode) {
    mode.masks = {{side, TransferFunction({{-0.001, 0.0}, {0.001, 1.0}, {1.0, 1.0}})}};
  });
  Session a_session(masked), b_session(tool_scene(plane(), one));
  for (int i = 0; i < 1000; ++i) {
    const double t = i * dt;
    const Pose device{{0.004 * std::sin(7 * t), 0.01 - 0.013 * std::min(1.0, 4 * t), 0.005 * std::sin(3 * t)},
                      turn_by({0.1 * std::sin(4 * t), 0.1 * std::sin(5 * t), 0.05 * std::sin(3 * t)})};
    const Tick x = felt(a_session, device), y = felt(b_session, device);
    ASSERT_LT(norm(x.force_n - y.force_n), 1e-5) << i;
    ASSERT_LT(norm(x.torque_nm - y.torque_nm), 1e-6) << i;
  }
}

// ---- modes at the first foot, elastic levels ----

// A push acts at the first foot, or at all: force and torque about the device.
TEST(ToolsHeldOut, AFlowPushesTheFirstFootUnlessAskedForAll) {
  const Vec3 push_n{0.0, 0.3, 0.0};
  const std::vector<Vec3> feet{{0.05, 0, 0}, {0.02, 0, 0}, {-0.01, 0, 0}};
  for (const auto which :
       {std::optional<SceneMode::Feet>{}, std::optional{SceneMode::Feet::first}, std::optional{SceneMode::Feet::all}}) {
    Scene scene =
        test::plain_scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.0, .max_force_n = 100.0, .max_torque_nm = 10.0});
    const FieldPtr flow = test::vector_formula([](const Vec3&) { return VectorSample{{0, 1, 0}, {}, true}; }, 0.8, 1e-3);
    scene.add("push", VectorForce{.field = scene.add("flow", test::volume_of(flow, "m/s")), .strength_n = Strength{push_n.y}});
    scene.edit_mode("push", [&](SceneMode& mode) { mode.feet = which; });
    ToolOptions tool = points(feet);
    tool.turning_radius_m = ToolSetting{.kappa = 5.0}.radius_m();
    scene.set(tool);
    Session session(scene);
    Tick tick;
    for (int i = 0; i < 200; ++i) tick = felt(session, {{}, {}});
    const bool all = which == SceneMode::Feet::all;
    EXPECT_NEAR(tick.force_n.y, (all ? 3 : 1) * push_n.y, 1e-6);
    Vec3 torque_nm;
    for (std::size_t foot = 0; foot < (all ? feet.size() : 1u); ++foot)
      torque_nm += cross(rotated(tick.proxy_turn, feet[foot]), push_n);
    EXPECT_LT(norm(tick.torque_nm - torque_nm), 1e-6);
  }
}

// A pad flat on an elastic level: the levels under its feet in parallel, in series with the coupling.
TEST(ToolsHeldOut, APadOnAnElasticLevelIsSpringsInParallelAndInSeries) {
  const double elastic = 300.0, depth_m = 0.004;
  for (const int feet : {1, 4, 16}) {
    for (const bool shared : {false, true}) {
      std::vector<Vec3> at;
      for (int i = 0; i < feet; ++i)
        at.push_back(
            {0.01 * std::cos(2.0 * std::numbers::pi * i / feet), 0, 0.01 * std::sin(2.0 * std::numbers::pi * i / feet)});
      Scene scene = tool_scene(plane(), points(at), {.kappa = 50.0, .share = shared ? 1.0 / feet : 1.0});
      scene.edit<SurfaceAndFriction>("surface", [&](SurfaceAndFriction& skin) {
        skin.levels.front().stiffness_n_per_m = elastic;
        skin.levels.front().strength_n = 100.0;
      });
      if (feet == 1)
        scene.edit<ToolOptions>([&](ToolOptions& tool) {
          tool.points_m = {{0, 0, 0}, {0, 0, 0}};
          tool.share = 0.5;
        });
      Session session(scene);
      const Tick tick = go(session, {{0, 0.005, 0}, {}}, {{0, -depth_m, 0}, {}}, 100);
      const double all = feet == 1 || shared ? elastic : feet * elastic;
      EXPECT_NEAR(tick.force_n.y, depth_m * k * all / (k + all), 1e-4) << feet << " shared " << shared;
      EXPECT_LT(norm(tick.torque_nm), 1e-6);
    }
  }
}

// A pad that rolls and turns on an elastic ball, 5 mm deep: a foot leaves its linear way by more than a tolerance of the path
// in each move, which the facets of its footing must allow for: nearly every tick is a single move.
TEST(ToolsHeldOut, APadRolledOverAnElasticBallFollowsTheHand) {
  constexpr double ball_m = 0.03;
  for (const double friction_n : {0.0, 0.2}) {
    Scene scene =
        test::plain_scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.0, .max_force_n = 100.0, .max_torque_nm = 10.0});
    const FieldPtr field = ball(ball_m);
    const FieldRef solid = scene.add("solid", test::volume_of(field), {}, test::filter_of(*field));
    scene.add("surface",
              SurfaceAndFriction{.field = solid,
                                 .levels = {{.name = "skin", .value = 0.0, .strength_n = strong_n, .stiffness_n_per_m = 500.0}},
                                 .friction_n = friction_n});
    ToolOptions tool = pad(0.012, 16);
    tool.share = 1.0 / 16.0, tool.turning_radius_m = ToolSetting{.kappa = 0.1}.radius_m();
    scene.set(tool);
    Session session(scene);
    constexpr int ticks = 3000;
    int behind = 0, moves = 0;
    double furthest_n = 0.0, pressed_n = 0.0;
    for (int i = 0; i < ticks; ++i) {
      const double t = i * dt, angle = 0.9 * std::sin(3.0 * t), lean = 0.5 * std::sin(2.0 * t);
      const Turn over = turn_by({lean, angle, 0.4 * std::sin(5.0 * t)});
      const double height_m = ball_m + 0.005 - 0.015 * std::min(1.0, 5.0 * t);
      const Tick tick = felt(session, {rotated(over, {0, 0, height_m}), turn_by({0.8 * lean, 0.7 * angle, 0.0}) * over});
      behind += tick.status != TickStatus::complete;
      moves += tick.sub_steps;
      furthest_n = std::max(furthest_n, tick.unborne_n);
      pressed_n = std::max(pressed_n, norm(tick.force_n));
    }
    EXPECT_EQ(behind, 0) << friction_n;
    EXPECT_LT(moves, 3 * ticks / 2) << friction_n;
    EXPECT_LT(furthest_n, 1e-3) << friction_n;
    EXPECT_GT(pressed_n, 1.0);
  }
}

// ---- speed ----

// Shot at a wall at 10 m/s with a spin, no foot of a rod of any number of feet passes, and the rest does not depend on it.
TEST(ToolsHeldOut, ARodOfAnyNumberOfFeetIsStoppedAt10MetresPerSecond) {
  for (const Vec3& out : {Vec3{0, 1, 0}, normalized(Vec3{0.3, 1, -0.5})}) {
    std::vector<Tick> rests;
    for (const int feet : {2, 16, 64}) {
      const FieldPtr solid = plane(out);
      const Scene scene = tool_scene(solid, rod(0.1, feet), {.kappa = 2.0});
      const Tool tool(scene.tool(), scene.coupling());
      Session session(scene);
      Tick tick;
      for (int i = 0; i < 400; ++i) {
        const double t = std::min(0.02, i * dt);
        tick = felt(session, {{0, 0.12 - 6.5 * t, 0.0}, turn_by({2.0 * t, -10.0 * t, 10.0 * t})});
        ASSERT_TRUE(is_finite(tick.force_n) && is_finite(tick.torque_nm));
        ASSERT_LE(deepest_m(*solid, tool, tick), 1e-5) << feet << " " << i;
      }
      Session fast(scene);
      for (int i = 0; i < 200; ++i) {
        const double t = std::min(0.013, i * dt);
        tick = felt(fast, {{0, 0.12 - 10.0 * t, 0.0}, turn_by({2.0 * t, -10.0 * t, 10.0 * t})});
        ASSERT_LE(deepest_m(*solid, tool, tick), 1e-5) << feet << " " << i;
      }
      rests.push_back(tick);
    }
    for (const Tick& tick : rests) {
      EXPECT_LT(norm(tick.force_n - rests.front().force_n), 1e-3);
      EXPECT_LT(norm(tick.torque_nm - rests.front().torque_nm), 1e-4);
    }
  }
}

}  // namespace tools_held_out_test
}  // namespace palpa
