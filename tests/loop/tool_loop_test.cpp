// A tool in the loop: torque beside force from the session to the device, its work, and a device's limits of turning.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"
#include "tests/loop/scenes.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace tool_loop_test {

using test::Random;

constexpr double dt_s = 1e-3;

/// A wall whose inside is where the coordinate along `inwards` is above zero, and a stick with its tip at a lever of 0.05 m.
Scene wall_scene() {
  Scene scene({.stiffness_n_per_m = 500, .max_force_n = 20.0, .max_torque_nm = 2.0});
  const FieldRef wall = scene.add("wall", plane_field(0.5));
  scene.add("wall", SurfaceAndFriction{.field = wall, .levels = {{.value = 0.0, .strength_n = 20.0}}});
  scene.set(ToolOptions{.shape = ToolOptions::Shape::points, .points_m = {{0.05, 0, 0}}, .turning_radius_m = 0.04});
  return scene;
}

/// Direction into it: that of its field's gradient.
Vec3 inwards() {
  Scene scene;
  return normalized(scene.field(scene.add("wall", plane_field(0.5))).field->scalar({}).gradient);
}

/// A hand that moves and turns smoothly about the wall, the tip in it most of the time.
Probe random_probe(int tick) {
  const double t_s = tick * dt_s;
  return {.position_m = {0.01 * std::sin(2.0 * t_s), 0.01 * std::sin(3.1 * t_s), 0.01 * std::sin(4.3 * t_s)},
          .turn = turn_by({0.3 * std::sin(1.7 * t_s), 0.4 * std::sin(2.3 * t_s), 0.2 * std::sin(3.7 * t_s)})};
}

TEST(ToolInTheLoop, BooksWorkOfForceAndTorque) {
  for (const double device_nm : {0.0, 0.05, 5.0}) {
    for (const bool motors : {false, true}) {
      Session session(wall_scene());
      const GuardOptions options{.max_force_n = 4.0, .motors = motors, .ramp_s = 0.1, .max_torque_nm = device_nm};
      GuardedSession guarded(session, options);
      Tick last;
      Command sent;
      double unfelt_j = 0.0, torque_j = 0.0, most_nm = 0.0;
      for (int i = 0; i < 4000; ++i) {
        const TickFrame frame = guarded.tick(i, i * dt_s, dt_s, random_probe(i));
        const Vec3 &step_m = frame.result.probe_step_m, &turn_rad = frame.result.probe_turn_step_rad;
        const Command& command = frame.command;
        ASSERT_LE(norm(command.force_n), 4.0);
        ASSERT_LE(norm(command.torque_nm), std::min(device_nm, 2.0));
        ASSERT_NEAR(command.work_on_hand_j, dot(sent.force_n, step_m) + dot(sent.torque_nm, turn_rad), 1e-15);
        ASSERT_NEAR(command.work_on_hand_j + command.withheld_j, dot(last.force_n, step_m) + dot(last.torque_nm, turn_rad),
                    1e-15);
        ASSERT_NEAR(command.unfelt_j, device_nm > 0.0 ? 0.0 : -dot(last.torque_nm, turn_rad), 1e-15);
        unfelt_j += std::abs(command.unfelt_j);
        torque_j += std::abs(dot(last.torque_nm, turn_rad));
        most_nm = std::max(most_nm, norm(command.torque_nm));
        last = frame.result;
        sent = command;
      }
      EXPECT_GT(torque_j, 1e-3) << "the wall is felt";
      EXPECT_EQ(unfelt_j > 0.0, device_nm == 0.0);
      EXPECT_EQ(most_nm > 0.0, device_nm > 0.0);
      if (device_nm == 0.05) {
        EXPECT_NEAR(most_nm, 0.05, 1e-12);
      }
    }
  }
}

// Tilt a stick into the wall, draw it out, turn it upright: without torque each round brings in energy; with it none.
TEST(ToolInTheLoop, TurningBringsInEnergyWhereTheTorqueCannotBeFelt) {
  const Vec3 in = inwards(), tips = cross(Vec3{1, 0, 0}, in);
  double given_j[2] = {}, unfelt_j[2] = {};
  for (const bool has_torque : {false, true}) {
    Session session(wall_scene());
    GuardedSession guarded(session, {.max_force_n = 20.0, .motors = false, .max_torque_nm = has_torque ? 2.0 : 0.0});
    int tick = 0;
    // Depth of the device's point and tilt of the stick into the wall, along straight lines.
    const auto go = [&](double from_m, double to_m, double from_rad, double to_rad) {
      for (int i = 0; i <= 1000; ++i, ++tick) {
        const double share = i / 1000.0;
        const double depth_m = from_m + share * (to_m - from_m), tilt_rad = from_rad + share * (to_rad - from_rad);
        const Probe probe{.position_m = depth_m * in, .turn = turn_by(tilt_rad * tips)};
        const TickFrame frame = guarded.tick(tick, tick * dt_s, dt_s, probe);
        given_j[has_torque] += frame.command.work_on_hand_j;
        unfelt_j[has_torque] += frame.command.unfelt_j;
      }
    };
    go(-0.03, -0.005, 0.0, 0.0);
    go(-0.005, -0.005, 0.0, 0.3);  // the tip goes into the wall
    go(-0.005, -0.03, 0.3, 0.3);   // and pushes the hand out
    go(-0.03, -0.03, 0.3, 0.0);
  }
  // At most the error of holding a force for a tick, k/2 Σ|Δp|².
  EXPECT_LT(std::abs(given_j[1]), 2e-4) << "with its torque the round gives nothing";
  EXPECT_EQ(unfelt_j[1], 0.0);
  EXPECT_GT(unfelt_j[0], 1e-3);
  EXPECT_NEAR(given_j[0], unfelt_j[0] + given_j[1], 1e-12) << "what is not felt is booked";
}

TEST(ToolInTheLoop, APointTakesNoNoticeOfTurns) {
  Session still(test::head_scene()), turned(test::head_scene());
  GuardedSession guarded_still(still, {.max_force_n = 3.0, .ramp_s = 0.1});
  GuardedSession guarded_turned(turned, {.max_force_n = 3.0, .ramp_s = 0.1, .max_torque_nm = 1.0});
  double most_n = 0.0;
  for (int i = 0; i < 1500; ++i) {
    Probe probe{.position_m = {0, 0.09 - 3e-5 * i, 1e-3 * std::sin(0.01 * i)}};
    const TickFrame plain = guarded_still.tick(i, i * dt_s, dt_s, probe);
    probe.turn = turn_by({0.01 * i, 0, 0.003 * i});
    const TickFrame frame = guarded_turned.tick(i, i * dt_s, dt_s, probe);
    ASSERT_EQ(frame.command.force_n, plain.command.force_n) << i;
    ASSERT_EQ(frame.command.torque_nm, Vec3{});
    ASSERT_EQ(frame.command.unfelt_j, 0.0);
    ASSERT_EQ(frame.command.work_on_hand_j, plain.command.work_on_hand_j);
    most_n = std::max(most_n, norm(frame.command.force_n));
  }
  EXPECT_GT(most_n, 0.3);
}

TEST(ToolInTheLoop, APoseThatIsNoRotationIsAFaultWithoutAForce) {
  Session session(wall_scene());
  GuardedSession guarded(session, {.max_force_n = 4.0, .ramp_s = 0.05, .max_torque_nm = 1.0});
  const Vec3 place_m = 0.01 * inwards();
  int tick = 0;
  const auto feel = [&](const Turn& turn) {
    const TickFrame frame = guarded.tick(tick, tick * dt_s, dt_s, {.position_m = place_m, .turn = turn});
    ++tick;
    return frame.command;
  };
  for (const Turn& wrong : {Turn{0, 0, 0, 0}, Turn{2, 0, 0, 0}, Turn{NAN, 0, 0, 0}, Turn{1, INFINITY, 0, 0}}) {
    for (int i = 0; i < 1000; ++i) feel({});
    EXPECT_EQ(feel({}).guard, GuardState::pass);
    for (int i = 0; i < 3; ++i) feel(wrong);
    const Command command = feel(wrong);
    EXPECT_EQ(command.force_n, Vec3{});
    EXPECT_EQ(command.torque_nm, Vec3{});
    EXPECT_EQ(command.cause, GuardCause::no_position);
  }
}

// ---- a device's limits ----

TEST(ClampedTo, LowersTheTurningRadiusAndItsDampingOfATool) {
  const DeviceLimits limits{.max_turn_stiffness_nm_per_rad = 0.2, .max_turn_damping_nms_per_rad = 1e-3};
  Scene scene = wall_scene();
  scene.edit<CouplingOptions>([](auto& coupling) { coupling.damping_ns_per_m = 5.0; });
  const Scene clamped = clamped_to(scene, limits);
  const double radius_m = *clamped.tool().turning_radius_m;
  EXPECT_NEAR(500.0 * radius_m * radius_m, 0.2, 1e-12);
  EXPECT_EQ(clamped.coupling().turn_damping_nms_per_rad, 1e-3) << "of 5 N·s/m at that radius";
  EXPECT_EQ(clamped.coupling().stiffness_n_per_m, 500.0);
  // Within the limits nothing changes.
  EXPECT_EQ(clamped_to(scene, {}).tool(), scene.tool());
  EXPECT_EQ(clamped_to(scene, {}).coupling(), scene.coupling());
  EXPECT_EQ(clamped_to(test::head_scene(), limits).tool(), test::head_scene().tool()) << "a point does not turn";
  // With the lower stiffness of translation the same radius is within the limit.
  EXPECT_EQ(clamped_to(scene, {.max_stiffness_n_per_m = 100, .max_turn_stiffness_nm_per_rad = 0.2}).tool(), scene.tool());
  // Of a default radius and of a damping of the scene's own.
  scene.edit<ToolOptions>([](auto& tool) { tool.turning_radius_m.reset(); });
  scene.edit<CouplingOptions>([](auto& coupling) { coupling.turn_damping_nms_per_rad = 0.5; });
  EXPECT_NEAR(500.0 * std::pow(*clamped_to(scene, limits).tool().turning_radius_m, 2), 0.2, 1e-12);
  EXPECT_EQ(clamped_to(scene, limits).coupling().turn_damping_nms_per_rad, 1e-3);
}

}  // namespace tool_loop_test
}  // namespace palpa
