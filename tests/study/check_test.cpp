// Closed loops of devices on scenes: bounds that have a closed form, what is found at fault, and advice that helps.
#include "palpa/study/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "palpa/mode/modes.h"
#include "palpa/scene/change_text.h"
#include "palpa/study/let_go.h"
#include "palpa/study/movement.h"
#include "palpa/volume/analytic.h"

namespace palpa {
namespace {

constexpr double tick_s = 1e-3;
constexpr double strong_n = 5.0;
const Vec3 at_world_m{0.006, 0.0, 0.0};  // on the plane, within the vortex, where the flow goes along y

/// Modes on a plane and a vortex, and the way in the world in which they hold.
struct Held {
  const char* name;
  std::vector<Mode> modes;
  Vec3 way;
};

Scene scene_of(const Held& held, double stiffness_n_per_m) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = 0.0, .max_force_n = 50.0});
  scene.add("wall", plane_field());
  scene.add("flow", lamb_oseen_vortex());
  scene.workspace = {.scale = 1.0, .center_m = Vec3{}};
  for (std::size_t n = 0; n < held.modes.size(); ++n) scene.add("mode" + std::to_string(n), held.modes[n]);
  return scene;
}

SurfaceAndFriction wall(double friction_n = 0.0) {
  return {.field = {"wall"}, .levels = {{.value = 0.0, .strength_n = Strength{strong_n}}}, .friction_n = friction_n};
}

/// Every mode that holds, and combinations. Directed forces hold nothing, so they stand with what does.
std::vector<Held> all_that_hold() {
  const Vec3 in{0, 0, -1}, across{1, 0, 0}, along{0, 1, 0};
  const Strength strong{strong_n};
  const FieldRef flow{"flow"};
  return {{"surface", {wall()}, in},
          {"surface with friction", {wall(1.0)}, in},
          {"viscosity", {Viscosity{.strength_n = strong}}, across},
          {"follow", {Follow{.field = flow, .strength_n = strong}}, across},
          {"front shape", {FrontShape{.field = flow, .strength_n = strong}}, -1.0 * along},
          {"transverse damping", {TransverseDamping{.field = flow, .drag_ns_per_m = 0.0, .strength_n = strong}}, across},
          {"vortex plane", {VortexPlane{.field = flow, .strength_n = strong}}, across},
          {"surface and viscosity", {wall(), Viscosity{.strength_n = strong}}, in},
          {"surface and wind", {wall(), VectorForce{.field = flow, .strength_n = Strength{0.2}}}, in},
          {"follow and viscosity", {Follow{.field = flow, .strength_n = strong}, Viscosity{.strength_n = strong}}, across},
          {"five",
           {wall(1.0), Follow{.field = flow, .strength_n = strong}, Viscosity{.strength_n = strong},
            FrontShape{.field = flow, .strength_n = strong}, TransverseDamping{.field = flow, .strength_n = strong}},
           in}};
}

double swing_m(const FeltRun& run, const Vec3& way, std::size_t begin, std::size_t end) {
  double low = INFINITY, high = -INFINITY;
  for (std::size_t n = begin; n < end; ++n) {
    const double along_m = dot(run.ticks[n].probe_m, way);
    low = std::min(low, along_m);
    high = std::max(high, along_m);
  }
  return high - low;
}

/// Whether a mass, pushed against what holds, swings by half as much a second later: beyond the bound primitives are at their
/// strength, so that the swing stays as large as it is.
bool settles(const Held& held, const DevicePlant& plant, double stiffness_n_per_m) {
  constexpr double push_n = 0.5, before_m = 1e-5;
  const Scene scene = scene_of(held, stiffness_n_per_m);
  const Similarity map = scene.hand_to_world();
  const Vec3 way = normalized(map.gradient_to_hand(held.way));
  const auto device = let_go(plant, map.to_hand(at_world_m) - before_m * way, push_n * way);
  const FeltRun run = feel(scene, *device, 3.0);
  const double early_m = swing_m(run, way, 1500, 2000), late_m = swing_m(run, way, 2500, 3000);
  return late_m < 1e-6 || late_m < 0.5 * early_m;
}

TEST(Check, EveryModeIsStableUpToTheClosedFormBound) {
  for (const double damping : {2.0, 5.0}) {
    for (const int delay_ticks : {0, 1}) {
      const DevicePlant plant{.mass_kg = 0.1, .damping_ns_per_m = damping, .delay_ticks = delay_ticks};
      const double bound = stiffness_bounds(plant, 0.0, tick_s).stable_n_per_m;
      EXPECT_NEAR(bound, damping / (tick_s * (0.5 + delay_ticks)), 1e-9);
      for (const Held& held : all_that_hold()) {
        const double critical =
            largest_stable_stiffness_n_per_m([&](double k) { return settles(held, plant, k); }, 0.3 * bound, 3.0 * bound);
        EXPECT_GE(critical / bound, 0.8) << held.name << ", b = " << damping << ", " << delay_ticks << " ticks late";
        EXPECT_LE(critical / bound, 1.0) << held.name << ", b = " << damping << ", " << delay_ticks << " ticks late";
      }
    }
  }
}

TEST(Check, AHeldWallBringsInWhatTheClosedFormSays) {
  constexpr double k = 800.0, amplitude_m = 0.005;
  const Scene scene = [] {
    Scene strong({.stiffness_n_per_m = k, .damping_ns_per_m = 0.0, .max_force_n = 50.0});
    strong.add("wall", plane_field());
    strong.workspace = {.scale = 1.0, .center_m = Vec3{}};
    strong.add("wall", SurfaceAndFriction{.field = {"wall"}, .levels = {{.value = 0.0, .strength_n = Strength{50.0}}}});
    return strong;
  }();
  const Similarity map = scene.hand_to_world();
  const Vec3 in = normalized(map.gradient_to_hand({0, 0, -1})), from_m = map.to_hand({});
  for (const double hz : {1.0, 4.0, 20.0}) {
    for (const int delay_ticks : {0, 1}) {
      Session session(scene);
      const int cycle = static_cast<int>(std::lround(1.0 / (hz * tick_s)));
      std::vector<Vec3> forces_n(static_cast<std::size_t>(delay_ticks));
      double work_j = 0.0;
      Vec3 last_m = from_m - amplitude_m * in;
      for (int n = 0; n <= 5 * cycle; ++n) {
        const Vec3 now_m = from_m + amplitude_m * std::sin(2.0 * std::numbers::pi * (n - cycle / 4.0) / cycle) * in;
        if (n > cycle) work_j += dot(forces_n[forces_n.size() - 1 - static_cast<std::size_t>(delay_ticks)], now_m - last_m);
        forces_n.push_back(session.tick({.position_m = now_m}, tick_s).force_n);
        last_m = now_m;
      }
      const double expected = held_wall_energy_j(k, amplitude_m, hz, tick_s, delay_ticks * tick_s);
      EXPECT_NEAR(work_j / 4.0 / expected, 1.0, 0.01) << hz << " Hz, " << delay_ticks;
    }
  }
}

TEST(Check, BoundsAreThoseOfTheBooks) {
  DevicePlant plant{.mass_kg = 0.1, .damping_ns_per_m = 1.0, .coulomb_friction_n = 0.03};
  plant.limits.encoder_step_m = 50e-6;
  EXPECT_DOUBLE_EQ(stiffness_bounds(plant, 0.0, 1e-3).passive_n_per_m, 2000.0);
  EXPECT_DOUBLE_EQ(stiffness_bounds(plant, 0.4, 1e-3).passive_n_per_m, 1200.0);
  EXPECT_DOUBLE_EQ(stiffness_bounds(plant, 2.0, 1e-3).passive_n_per_m, 0.0);
  EXPECT_DOUBLE_EQ(stiffness_bounds(plant, 0.0, 1e-3).encoder_n_per_m, 1200.0);
  plant.delay_ticks = 1;
  EXPECT_DOUBLE_EQ(stiffness_bounds(plant, 0.5, 1e-3).stable_n_per_m, 1000.0);
}

/// A ball that a device lies on.
Scene ball(double stiffness_n_per_m, double damping_ns_per_m) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = damping_ns_per_m, .max_force_n = 10.0});
  scene.add("ball", sphere_field());
  scene.workspace = {.scale = 1.0, .center_m = Vec3{}};
  scene.add("skin",
            SurfaceAndFriction{.field = {"ball"}, .levels = {{.value = 0.0, .strength_n = Strength{8.0}}}, .friction_n = 0.2});
  return scene;
}

TEST(Check, FindsASceneMadeUnstableAndItsAdviceHelps) {
  const Scene unstable = ball(5000.0, 0.0);
  const DevicePlant omega = device_plant("omega");
  const CheckReport report = check(unstable, omega);
  ASSERT_EQ(report.grade, Grade::stop) << to_table(report);
  ASSERT_FALSE(report.changes.empty()) << to_table(report);
  EXPECT_NE(report.grade_after, Grade::stop);
  const CheckReport after = check(changed(unstable, report.changes), omega, {.advise = false});
  EXPECT_NE(after.grade, Grade::stop) << to_table(after);
  EXPECT_EQ(check_quickly(unstable, omega).grade, Grade::stop);
}

TEST(Check, LetsASoftSceneBe) {
  const Scene soft = ball(150.0, 0.5);
  const CheckReport report = check(soft, device_plant("omega"));
  EXPECT_EQ(report.grade, Grade::fine) << to_table(report);
  EXPECT_TRUE(report.changes.empty()) << to_table(report);
}

TEST(Check, IsTheSameEveryTime) {
  const Scene scene = ball(3000.0, 0.2);
  const DevicePlant desktop = device_plant("desktop");
  EXPECT_EQ(to_json(check(scene, desktop, {.map = true})), to_json(check(scene, desktop, {.map = true})));
}

TEST(Check, SaysAsJsonWhatItSaysInWords) {
  const CheckReport report = check_quickly(ball(5000.0, 0.0), device_plant("omega"));
  const auto json = nlohmann::json::parse(to_json(report));
  EXPECT_EQ(json["verdict"], "stop");
  EXPECT_EQ(json["reason"], report.verdict);
  EXPECT_THAT(to_table(report), testing::StartsWith("stop on omega: "));
}

TEST(Check, ASceneWithNothingToFeelIsFineAndSaysSo) {
  Scene scene;
  scene.add("ball", sphere_field());
  const CheckReport report = check(scene, device_plant("touch"));
  EXPECT_EQ(report.grade, Grade::fine);
  EXPECT_EQ(report.verdict, "nothing is felt within reach of a hand");
}

TEST(Check, ADeviceWithoutMassIsRefused) { EXPECT_THROW((void)check(ball(500.0, 0.2), {.name = "ideal"}), LoadError); }

TEST(Check, IsOfWhatTheDeviceBears) {
  const CheckReport report = check(ball(5000.0, 0.2), device_plant("touch"));
  EXPECT_EQ(report.coupling.stiffness_n_per_m, 400.0);
  EXPECT_EQ(report.coupling.max_force_n, 3.3);
  ASSERT_FALSE(report.changes.empty());
  EXPECT_EQ(report.changes.front().from, 5000.0);
}

TEST(ChangeText, ChangesOneNumberAndNothingElse) {
  const std::string text = "# mine, größer\n[coupling]  # k\nstiffness_n_per_m = 600 # N/m\nmax_force_n = 7.0\n\n[volume.a]\n";
  EXPECT_EQ(with_number(text, "coupling", "stiffness_n_per_m", 250.0),
            "# mine, größer\n[coupling]  # k\nstiffness_n_per_m = 250 # N/m\nmax_force_n = 7.0\n\n[volume.a]\n");
  EXPECT_EQ(with_number(text, "coupling", "damping_ns_per_m", 0.5),
            "# mine, größer\n[coupling]  # k\ndamping_ns_per_m = 0.5\nstiffness_n_per_m = 600 # N/m\nmax_force_n = 7.0\n\n"
            "[volume.a]\n");
  EXPECT_EQ(with_number("a = 1", "coupling", "max_force_n", 3.3), "a = 1\n\n[coupling]\nmax_force_n = 3.3\n");
  EXPECT_EQ(with_number("coupling = {max_force_n=7}\n", "coupling", "max_force_n", 3.3), "coupling = {max_force_n=3.3}\n");
  EXPECT_EQ(with_number("coupling = {max_force_n=7}\n", "coupling", "damping_ns_per_m", 0.5),
            "coupling = {damping_ns_per_m = 0.5, max_force_n=7}\n");
  EXPECT_EQ(with_number("coupling.max_force_n = 7\n", "coupling", "max_force_n", 3.3), "coupling.max_force_n = 3.3\n");
  EXPECT_THROW(with_number("[coupling\n", "coupling", "max_force_n", 3.3), SceneError);
}

}  // namespace
}  // namespace palpa
