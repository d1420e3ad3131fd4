// Energy of a tool's ticks: identity of the ledger with damper, lag, faults and moving data; damper of turning.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "palpa/session/session.h"
#include "tests/session/busy_scene.h"
#include "tests/session/hands.h"
#include "tests/session/hostile_scene.h"

namespace palpa {
namespace tool_energy_test {

constexpr double dt = 1e-3;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Scene with_tool(Scene scene, ToolOptions tool) {
  tool.turning_radius_m = 0.02;
  scene.set(tool);
  scene.edit<CouplingOptions>([](CouplingOptions& coupling) {
    coupling.damping_ns_per_m = 0.5;
    coupling.turn_damping_nms_per_rad = 5e-4;
  });
  return scene;
}

const ToolOptions rod{.shape = ToolOptions::Shape::rod, .length_m = 0.02, .points = 8};
const ToolOptions pad{.shape = ToolOptions::Shape::pad, .radius_m = 0.01, .points = 16};

// Work of a tick's held force and torque on the hand against its booked energy.
class Books {
 public:
  void check(const Tick& tick) {
    const Energy& e = tick.energy;
    const double held_j = dot(before_.force_n, tick.probe_step_m) + dot(before_.torque_nm, tick.probe_turn_step_rad);
    const double fall_j = before_.energy.stored_j + before_.energy.elastic_j - e.stored_j - e.elastic_j;
    // After a fault force and springs begin anew: their energy is lost, without work.
    const double lost_j = before_.status == TickStatus::bad_input || tick.status == TickStatus::bad_input || !tick.probe_valid
                              ? fall_j - (0.0 - e.stored_j - e.elastic_j)
                              : 0.0;
    const double booked_j = fall_j - lost_j + e.sampling_bound_j + e.injected_j - e.dissipated_j + e.path_and_release_j +
                            e.data_motion_j + e.damper_j;
    const double size_j = std::abs(held_j) + std::abs(fall_j) + std::abs(e.injected_j) + std::abs(e.damper_j);
    EXPECT_NEAR(held_j, booked_j, 1e-12 + 1e-10 * size_j) << "tick " << ticks_ << ", " << static_cast<int>(tick.status);
    waiting_ += tick.status == TickStatus::waiting;
    damper_j_ += e.damper_j;
    ++ticks_;
    before_ = tick;
  }
  int waiting() const { return waiting_; }
  double damper_j() const { return damper_j_; }

 private:
  Tick before_;
  int ticks_ = 0, waiting_ = 0;
  double damper_j_ = 0.0;
};

// A hand that wanders and turns; now and then without a position, with an unusable one, or with no rotation at all.
Probe probe_at(const test::Wander& places, const test::Wander& turns, int i, bool faults) {
  Probe probe{.position_m = places.at(dt * i), .turn = turn_by(turns.at(dt * i))};
  if (!faults) return probe;
  if (i % 97 == 25) probe.turn = {0.0, 0.0, 0.0, 0.0};
  if (i % 97 == 50) probe.turn.x = nan;
  if (i % 97 == 75) probe.valid = false;
  if (i % 97 == 90) probe.position_m.z = nan;
  return probe;
}

TEST(ToolEnergy, HeldWorkIsWhatTheLedgerSays) {
  test::Random random(3);
  int waiting = 0;
  const Scene scenes[] = {test::busy_scene(false), test::busy_moving_scene(true), test::hostile_scene(random, 500.0),
                          test::hostile_scene(random, 2000.0)};
  for (const Scene& scene : scenes) {
    const double reach_m = &scene < &scenes[2] ? 0.09 : 0.02;
    for (const ToolOptions& tool : {rod, pad}) {
      for (const bool faults : {false, true}) {
        Session session(with_tool(scene, tool));
        const test::Wander places(random, reach_m), turns(random, 0.8);
        Books books;
        for (int i = 0; i < 250; ++i) {
          const Tick tick = session.tick(probe_at(places, turns, i, faults), dt);
          ASSERT_TRUE(is_finite(tick.force_n) && is_finite(tick.torque_nm));
          books.check(tick);
          if (testing::Test::HasFailure()) return;
        }
        waiting += books.waiting();
      }
    }
  }
  EXPECT_GT(waiting, 20) << "hostile data take more than a tick's work";
}

// A ring that sticks, turned at a constant rate: κ times the turn, and the damper's torque; its work is the damper's share.
TEST(ToolEnergy, TheDamperOfTurningResistsAndBooksItsWork) {
  constexpr double k = 800.0, radius_m = 0.02, damping_nms = 5e-4, rate_rad_per_s = 0.4;
  Scene scene({.stiffness_n_per_m = k, .max_torque_nm = 10.0});
  scene.add("wall", plane_field());
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  scene.add("skin", SurfaceAndFriction{
                        .field = {"wall"}, .levels = {{.value = 0.0, .strength_n = Strength{100.0}}}, .friction_n = 50.0});
  const Scene damped = with_tool(scene, pad);
  Scene undamped = damped;
  undamped.edit<CouplingOptions>([](CouplingOptions& coupling) {
    coupling.damping_ns_per_m = 0.0;
    coupling.turn_damping_nms_per_rad = 0.0;
  });
  Session session(damped), spring(undamped);
  for (int i = 0; i < 1200; ++i) {
    const double depth_m = 0.002 - 0.006 * std::min(1.0, i / 200.0), angle = rate_rad_per_s * std::max(0.0, dt * (i - 400));
    const Probe probe{.position_m = {0, 0, depth_m}, .turn = turn_by({0, 0, angle})};
    const Tick tick = session.tick(probe, dt), alone = spring.tick(probe, dt);
    if (i > 700) {
      EXPECT_NEAR(alone.torque_nm.z, -k * radius_m * radius_m * angle, 1e-5) << i;
      EXPECT_NEAR(tick.torque_nm.z - alone.torque_nm.z, -damping_nms * rate_rad_per_s, 1e-3 * damping_nms * rate_rad_per_s)
          << i;
      EXPECT_NEAR(tick.energy.damper_j, -damping_nms * rate_rad_per_s * rate_rad_per_s * dt,
                  1e-2 * damping_nms * rate_rad_per_s * rate_rad_per_s * dt);
      EXPECT_LT(norm(tick.force_n - alone.force_n), 1e-6) << "no motion, no damping";
    }
  }
}

}  // namespace tool_energy_test
}  // namespace palpa
