// Laws of a tool on the path: closed forms of rods, pads and pegs, symmetries, energy, walls (docs/theory.md 10, docs/path.md).
#include "tests/path/tools.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/solver/random_problems.h"

namespace palpa {
namespace tools_test {

using test::Random;
using Setting = ToolSetting;

// ---- closed forms ----

TEST(Tools, OnePointAtItsCentreIsThePointToTheBit) {
  Setting setting{.strength_n = 2.0, .friction_n = 0.3};
  const Scene with = tool_scene(ball(0.05), points({{0, 0, 0}}), setting);
  Scene without = with;
  without.set(ToolOptions{});
  Session a(with), b(without);
  Random random(1);
  Vec3 at_m{0, 0.06, 0};
  for (int i = 0; i < 2000; ++i) {
    at_m += random.in_cube(1e-3) - 2e-2 * (at_m - Vec3{0, 0.045, 0});
    const Tick one = felt(a, {at_m, turn_by(random.in_cube(3.0))}), other = felt(b, {at_m, {}});
    ASSERT_EQ(one.proxy_m, other.proxy_m) << i;
    ASSERT_EQ(one.force_n, other.force_n) << i;
    ASSERT_EQ(one.torque_nm, Vec3{});
    ASSERT_EQ(one.proxy_turn, Turn{});
  }
}

TEST(Tools, TwoFeetAtOnePlaceAreOneOfBothShares) {
  const Vec3 tip_m{0.02, -0.01, 0.0};
  Session both(tool_scene(ball(0.05), points({tip_m, tip_m}), {.strength_n = 2.0, .friction_n = 0.2, .share = 0.5}));
  Session one(tool_scene(ball(0.05), points({tip_m}), {.strength_n = 2.0, .friction_n = 0.2}));
  for (int i = 0; i < 1500; ++i) {
    const double t = i * dt;
    const Pose device{{-0.02 + 0.01 * std::sin(3 * t), 0.065 - 0.01 * std::min(1.0, t), 0.01 * std::sin(5 * t)},
                      turn_by({0.2 * std::sin(4 * t), 0.0, 0.1 * std::sin(7 * t)})};
    const Tick a = felt(both, device), b = felt(one, device);
    ASSERT_LT(distance(a.proxy_m, b.proxy_m), 1e-8) << i;
    ASSERT_LT(norm(a.force_n - b.force_n), 1e-5) << i;
    ASSERT_LT(norm(a.torque_nm - b.torque_nm), 1e-6) << i;
  }
}

// A rod flat on a plane bears its load by the lever rule, whatever the number of its feet.
TEST(Tools, ARodOnAPlaneFollowsTheLeverRule) {
  for (const int feet : {2, 3, 16, 64}) {
    ToolOptions tool = rod(0.1, feet);
    tool.centre_m = {0, 0, 0.02};
    Session session(tool_scene(plane(), tool));
    const Tick tick = go(session, {{0, 0.005, 0}, {}}, {{0, -0.003, 0}, {}}, 50);
    EXPECT_LT(norm(tick.force_n - Vec3{0, k * 0.003, 0}), 1e-6) << feet;
    EXPECT_LT(norm(tick.torque_nm), 1e-8) << feet;
    EXPECT_LT(norm(tilt_rad(tick)), 1e-9) << feet;
    if (feet > 2) continue;
    for (const PlacedPrimitive& row : session.primitives().last(2)) {
      const double share = row.lever_m.z > 0.0 ? 0.07 / 0.1 : 0.03 / 0.1;
      EXPECT_NEAR(row.force_n.y, share * k * 0.003, 1e-6);
    }
  }
}

// Pressed on by a tip at the side: k(δ − b sin θ) is the force, κθ the torque, and the tip's force has the lever b cos θ.
TEST(Tools, AStickAcrossAWallIsTheNonlinearMinimum) {
  for (const double kappa : {0.5, 5.0}) {
    for (const double depth_m : {0.0005, 0.005, 0.02}) {
      const double b = 0.1;
      Session session(tool_scene(plane(), points({{b, 0, 0}}), {.kappa = kappa}));
      const Tick tick = go(session, {{0, 0.002, 0}, {}}, {{0, -depth_m, 0}, {}}, 200);
      double low = 0.0, high = 0.5 * std::numbers::pi;
      for (int i = 0; i < 100; ++i) {
        const double angle = 0.5 * (low + high);
        const double push_n = k * (depth_m - b * std::sin(angle));
        (kappa * angle < push_n * b * std::cos(angle) ? low : high) = angle;
      }
      const double push_n = k * (depth_m - b * std::sin(low));
      EXPECT_NEAR(tick.force_n.y, push_n, 1e-5 * push_n + 1e-6) << kappa << " " << depth_m;
      EXPECT_NEAR(tick.torque_nm.z, kappa * low, 1e-5 * kappa * low + 1e-7) << kappa << " " << depth_m;
      EXPECT_NEAR(tilt_rad(tick).z, low, 1e-5 * low + 1e-8) << kappa << " " << depth_m;
    }
  }
}

TEST(Tools, AShellBreaksAtTheDepthOfBothSprings) {
  const double s = 0.5, b = 0.05, kappa = 0.5;
  Session session(tool_scene(plane(), points({{b, 0, 0}}), {.kappa = kappa, .strength_n = s}));
  double angle = 0.0;
  for (int i = 0; i < 50; ++i) angle = s * b * std::cos(angle) / kappa;
  const double breaks_m = s / k + b * std::sin(angle);
  double broke_at_m = 0.0;
  for (int i = 0; i < 2000 && broke_at_m == 0.0; ++i) {
    const double y_m = 1e-3 - 5e-6 * i;
    felt(session, {{0, y_m, 0}, {}});
    for (const SessionEvent& event : session.events()) {
      if (event.kind == SessionEventKind::break_through) broke_at_m = -y_m;
    }
  }
  EXPECT_NEAR(broke_at_m, breaks_m, 6e-6);
}

// A peg on its axis in a hole turns until both ends touch: sin θ = 2R/L. The rest of the turn is torque, without a force.
TEST(Tools, APegInAHoleTurnsUntilItJams) {
  const double R = 0.001, L = 0.04, kappa = 0.5;
  for (const double asked_rad : {0.1, 0.5, 1.0}) {
    Session session(tool_scene(hole(R), rod(L, 8), {.kappa = kappa}));
    const Tick tick = go(session, {{0, 0, 0}, {}}, {{0, 0, 0}, turn_by({asked_rad, 0, 0})}, 400);
    const double angle = std::asin(2.0 * R / L);
    EXPECT_NEAR(tilt_rad(tick).x, angle, 1e-6) << asked_rad;
    EXPECT_NEAR(tick.torque_nm.x, kappa * (angle - asked_rad), 1e-6) << asked_rad;
    EXPECT_LT(norm(tick.force_n), 1e-4) << asked_rad;
  }
}

// A ring of feet with friction: N s r against spin, N s against sliding.
TEST(Tools, ARingRubsByTheSumOfItsFeet) {
  const double r = 0.01, s = 0.1;
  std::vector<Vec3> ring;
  for (int i = 0; i < 8; ++i)
    ring.push_back({r * std::cos(i * std::numbers::pi / 4), 0, r * std::sin(i * std::numbers::pi / 4)});
  {
    Session session(tool_scene(plane(), points(ring), {.friction_n = s}));
    go(session, {{0, 0.002, 0}, {}}, {{0, -0.004, 0}, {}}, 100);
    const Tick tick = go(session, {{0, -0.004, 0}, {}}, {{0, -0.004, 0}, turn_by({0, 0.5, 0})}, 500);
    EXPECT_NEAR(tick.torque_nm.y, -8 * s * r, 2e-6);
  }
  {
    Session session(tool_scene(plane(), points(ring), {.friction_n = s}));
    go(session, {{0, 0.002, 0}, {}}, {{0, -0.004, 0}, {}}, 100);
    const Tick tick = go(session, {{0, -0.004, 0}, {}}, {{0.02, -0.004, 0}, {}}, 500);
    EXPECT_NEAR(tick.force_n.x, -8 * s, 1e-5);
  }
}

// Friction by a coefficient is that of the least split: against spin the sum of each foot's load times its distance.
TEST(Tools, APadRubsByItsLoad) {
  const double r = 0.01, mu = 0.2, push_n = k * 0.004;
  std::vector<Vec3> ring;
  for (int i = 0; i < 8; ++i)
    ring.push_back({r * std::cos(i * std::numbers::pi / 4), 0, r * std::sin(i * std::numbers::pi / 4)});
  Session session(tool_scene(plane(), points(ring), {.friction_coefficient = mu}));
  go(session, {{0, 0.002, 0}, {}}, {{0, -0.004, 0}, {}}, 100);
  const Tick spun = go(session, {{0, -0.004, 0}, {}}, {{0, -0.004, 0}, turn_by({0, 0.5, 0})}, 500);
  EXPECT_NEAR(spun.torque_nm.y, -mu * push_n * r, 1e-5);
  const Tick slid = go(session, {{0, -0.004, 0}, turn_by({0, 0.5, 0})}, {{0.02, -0.004, 0}, turn_by({0, 0.5, 0})}, 500);
  EXPECT_LT(std::abs(slid.force_n.x), mu * push_n + 1e-5);
  EXPECT_GT(std::abs(slid.force_n.x), 0.9 * mu * push_n);
}

// A stick pushed along itself leans by φ/(1 − Fb/κ) for a device that leans by φ, and tips over where Fb exceeds κ.
TEST(Tools, AStickPushedAlongItselfLeansAndThenBuckles) {
  const double b = 0.1, kappa = 0.5, lean_rad = 1e-5;
  for (const double ratio : {0.1, 0.4, 0.8}) {
    const double push_n = ratio * kappa / b;
    Session session(tool_scene(plane(), points({{0, -b, 0}}), {.kappa = kappa}));
    const Turn turn = turn_by({0, 0, lean_rad});
    const Tick tick = go(session, {{0, b + 0.002, 0}, turn}, {{0, b - push_n / k, 0}, turn}, 300);
    EXPECT_NEAR(tilt_rad(tick).z / lean_rad, 1.0 / (1.0 - ratio), 0.02 / (1.0 - ratio)) << ratio;
  }
  Session session(tool_scene(plane(), points({{0, -b, 0}}), {.kappa = kappa}));
  const Turn turn = turn_by({0, 0, 1e-4});
  const Tick tick = go(session, {{0, b + 0.002, 0}, turn}, {{0, b - 1.2 * kappa / b / k, 0}, turn}, 600);
  EXPECT_GT(tilt_rad(tick).z, 0.1);
  EXPECT_NEAR(tick.torque_nm.z, tick.force_n.y * b * std::sin(tilt_rad(tick).z), 1e-4);
}

// A tool is its feet: between two of them an edge enters by half their distance.
TEST(Tools, ARodOverARidgeSinksByHalfTheDistanceOfItsFeet) {
  for (const double apart_m : {0.004, 0.01}) {
    Session session(tool_scene(ridge(), points({{-0.5 * apart_m, 0, 0}, {0.5 * apart_m, 0, 0}})));
    const Tick tick = go(session, {{0, 0.005, 0}, {}}, {{0, -0.5 * apart_m - 0.002, 0}, {}}, 200);
    EXPECT_NEAR(tick.proxy_m.y, -0.5 * apart_m, 1e-6);
    EXPECT_NEAR(tick.force_n.y, k * 0.002, 1e-3);
  }
}

// ---- symmetries ----

Pose loop_pose(double t) {
  return {{0.01 * std::sin(3 * t), 0.058 - 0.01 * std::min(1.0, t), 0.008 * std::sin(2 * t)},
          turn_by({0.3 * std::sin(2 * t), 0.2 * std::sin(t), 0.25 * std::sin(3 * t)})};
}

TEST(Tools, TurnedTogetherWithDataAndHandFeelTurned) {
  Random random(7);
  for (const double friction_n : {0.0, 0.1}) {
    const Vec3 out = random.direction();
    // The rotation that takes y to `out`.
    const Vec3 axis = cross(Vec3{0, 1, 0}, out);
    const Turn Q = turn_by(std::acos(out.y) * normalized(axis));
    const ToolOptions tool = pad(0.01, 8);
    Session straight(tool_scene(plane(), tool, {.friction_n = friction_n}));
    Session turned(tool_scene(plane(out), tool, {.friction_n = friction_n}));
    for (int i = 0; i < 1000; ++i) {
      Pose device = loop_pose(i * dt);
      device.position_m.y -= 0.05;
      const Tick a = felt(straight, device);
      const Tick b = felt(turned, {rotated(Q, device.position_m), Q * device.turn});
      ASSERT_LT(distance(rotated(Q, a.proxy_m), b.proxy_m), 1e-9) << i;
      ASSERT_LT(norm(rotated(Q, a.torque_nm) - b.torque_nm), 1e-8) << i;
    }
  }
}

TEST(Tools, DoNotDependOnTheOrderOfTheirFeet) {
  Random random(3);
  std::vector<Vec3> feet;
  for (int i = 0; i < 12; ++i) feet.push_back(random.in_cube(0.01));
  Session one(tool_scene(ball(0.05), points(feet)));
  std::ranges::reverse(feet);
  Session other(tool_scene(ball(0.05), points(feet)));
  for (int i = 0; i < 2000; ++i) {
    const Tick a = felt(one, loop_pose(i * dt)), b = felt(other, loop_pose(i * dt));
    ASSERT_LT(distance(a.proxy_m, b.proxy_m), 2e-8) << i;
    ASSERT_LT(norm(a.torque_nm - b.torque_nm), 1e-6) << i;
  }
}

// ---- energy ----

// Of a tick: the held force and torque do at most the fall of the spring's energy and the bound of the hold.
TEST(Tools, BringNoEnergyInBeyondTheHold) {
  for (const double friction_n : {0.0, 0.1}) {
    for (const auto& tool : {rod(0.04, 8), pad(0.01, 16)}) {
      Session session(tool_scene(ball(0.05), tool, {.friction_n = friction_n}));
      Tick before = felt(session, loop_pose(0.0));
      double work_j = 0.0, hold_j = 0.0;
      const double rounds_s = 2.0 * std::numbers::pi;
      for (int i = 1; i * dt < 2.0 * rounds_s; ++i) {
        const Tick tick = felt(session, loop_pose(1.0 + i * dt));
        const double held_j = dot(before.force_n, tick.probe_step_m) + dot(before.torque_nm, tick.probe_turn_step_rad);
        const double most_j =
            0.5 * k * norm_squared(tick.probe_step_m) + 0.5 * Setting{}.kappa * norm_squared(tick.probe_turn_step_rad);
        const double fall_j = before.energy.stored_j - tick.energy.stored_j;
        ASSERT_LE(held_j, fall_j + most_j + 1e-9) << i;
        ASSERT_LE(tick.energy.sampling_bound_j, most_j + 1e-12) << i;
        // The identity of the ledger, with the modes' works and the path's error.
        const double brought_j = tick.energy.sampling_bound_j + tick.energy.injected_j - tick.energy.dissipated_j +
                                 tick.energy.path_and_release_j + tick.energy.data_motion_j;
        ASSERT_NEAR(held_j, fall_j + brought_j, 1e-10) << i;
        work_j += held_j, hold_j += most_j;
        before = tick;
      }
      EXPECT_LE(work_j, hold_j + 1e-6);
    }
  }
}

TEST(Tools, FrictionlessLoopsClose) {
  for (const auto& tool : {rod(0.04, 8), pad(0.01, 16)}) {
    Session session(tool_scene(ball(0.05), tool));
    std::vector<Tick> first;
    const int ticks = 6283;  // 2π s: all three frequencies
    for (int i = 0; i < 3 * ticks; ++i) {
      const Tick tick = felt(session, loop_pose(1.0 + 2.0 * std::numbers::pi * i / ticks));
      if (i >= ticks && i < 2 * ticks) first.push_back(tick);
      if (i < 2 * ticks) continue;
      const Tick& then = first[static_cast<std::size_t>(i - 2 * ticks)];
      ASSERT_LT(distance(tick.proxy_m, then.proxy_m), 2e-6) << i;
      ASSERT_LT(norm(tick.torque_nm - then.torque_nm), 1e-4) << i;
    }
  }
}

TEST(Tools, AStillHandFeelsNothingMove) {
  for (const double friction_n : {0.0, 0.1}) {
    for (const auto& tool : {rod(0.04, 8), pad(0.01, 16), points({{0.01, -0.02, 0}})}) {
      Session session(tool_scene(ball(0.05), tool, {.friction_n = friction_n}));
      for (int i = 0; i < 1700; ++i) felt(session, loop_pose(i * dt));
      const Tick first = felt(session, loop_pose(1.7));
      for (int i = 0; i < 100; ++i) {
        const Tick tick = felt(session, loop_pose(1.7));
        ASSERT_LT(norm(tick.force_n - first.force_n), 1e-3) << friction_n << " " << i;
        ASSERT_LT(norm(tick.torque_nm - first.torque_nm), 5e-5) << friction_n << " " << i;
      }
    }
  }
}

// ---- walls ----

// No foot ends a tick behind a wall, beyond a hundredth of a sample spacing, at up to 10 m/s and 50 rad/s. A tool that the hand
// has twisted by 3 rad begins anew at the hand, wherever that is: the end of a walk.
TEST(Tools, NoFootPassesAWall) {
  Random random(5);
  for (const auto& [solid, start] : {std::pair{plane(), Vec3{0, 0.08, 0}}, std::pair{ball(0.05), Vec3{0, 0.13, 0}},
                                     std::pair{hole(0.02), Vec3{}}, std::pair{ridge(), Vec3{0, 0.08, 0}}}) {
    for (const auto& options : {rod(0.03, 8), pad(0.01, 16), points({{0.015, 0, 0}, {0, -0.012, 0.01}})}) {
      for (const double speed_m_per_s : {0.1, 1.0, 10.0}) {
        const Scene scene = tool_scene(solid, options);
        const Tool tool(scene.tool(), scene.coupling());
        Session session(scene);
        Pose device{start, {}};
        Vec3 velocity, spin;
        Turn held;
        for (int i = 0; i < 400; ++i) {
          velocity +=
              (0.2 * speed_m_per_s) * random.in_cube(1.0) - 0.02 * velocity - 20.0 * dt * (device.position_m - start * 0.5);
          velocity = shortened(velocity, speed_m_per_s);
          spin = shortened(spin + random.in_cube(5.0) * speed_m_per_s, 5.0 * speed_m_per_s);
          device.position_m = shortened(device.position_m + dt * velocity, 0.15);  // within the data
          device.turn = turned_further(device.turn, dt * spin);
          if (norm(rotation_between_rad(held, device.turn)) > 3.0) break;
          const Tick tick = felt(session, device);
          held = tick.proxy_turn;
          ASSERT_TRUE(is_finite(tick.force_n) && is_finite(tick.torque_nm));
          ASSERT_LE(deepest_m(*solid, tool, tick), 1e-5) << i << " at " << speed_m_per_s << " m/s, " << tool.feet() << " feet";
        }
      }
    }
  }
}

// Twisted by up to half a turn, and beyond: finite, and begun anew before the torque could reverse.
TEST(Tools, ATwistOfNearlyHalfATurnIsBoundedAndEnds) {
  // A slot between two walls across x.
  const FieldPtr slot = formula(
      [](const Vec3& x_m) {
        return ScalarSample{std::abs(x_m.x) - 0.002, {x_m.x < 0.0 ? -1.0 : 1.0, 0, 0}, true};
      },
      0.8, 1e-3);
  Session session(tool_scene(slot, rod(0.04, 4)));
  double most_nm = 0.0;
  for (int i = 0; i < 3500; ++i) {
    const Tick tick = felt(session, {{}, turn_by({0, 1e-3 * i, 0})});
    ASSERT_TRUE(is_finite(tick.torque_nm) && is_finite(tick.force_n));
    ASSERT_LE(norm(tick.torque_nm), 0.5 * 3.0 + 1e-6);
    most_nm = std::max(most_nm, norm(tick.torque_nm));
    if (i == 2900) {
      EXPECT_NEAR(tick.torque_nm.y, 0.5 * (std::asin(0.1) - 2.9), 1e-3);
    }
  }
  EXPECT_GT(most_nm, 1.4);
}

}  // namespace tools_test
}  // namespace palpa
