// Closed loops of devices on scenes: closed-form bounds, faults, advice.
#include "palpa/study/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>
#include <numbers>

#include "palpa/base/printed.h"
#include "palpa/data/analytic.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/change_text.h"
#include "palpa/study/movement.h"
#include "palpa/study/released_device.h"

namespace palpa {
namespace check_test {

using testing::HasSubstr;

constexpr double tick_s = 1e-3;
constexpr double strong_n = 5.0;
const Vec3 at_world_m{0.006, 0.0, 0.0};  // on the plane, within the vortex, where the flow is along y

/// Modes on a plane and a vortex, and the direction in the world in which they hold.
struct Held {
  const char* name;
  std::vector<Mode> modes;
  Vec3 way;
  Vec3 from_m = at_world_m;
};

Scene scene_of(const Held& held) {
  Scene scene({.damping_ns_per_m = 0.0, .max_force_n = 50.0});
  scene.add("wall", plane_field());
  scene.add("flow", lamb_oseen_vortex());
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  for (std::size_t n = 0; n < held.modes.size(); ++n) scene.add("mode" + std::to_string(n), held.modes[n]);
  return scene;
}

SurfaceAndFriction wall(double friction_n = 0.0) {
  return {.field = {"wall"}, .levels = {{.value = 0.0, .strength_n = Strength{strong_n}}}, .friction_n = friction_n};
}

/// Every mode, and combinations. Directed forces (gradient, vector and vortex force) hold nothing: alone they leave a device
/// without a spring, which has no critical stiffness. So they are combined with holding modes, whose result must not change. A
/// vortex line holds on the core, so there the device lies.
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
          {"vortex line", {VortexLine{.field = flow, .strength_n = strong}}, across, Vec3{}},
          {"surface and viscosity", {wall(), Viscosity{.strength_n = strong}}, in},
          {"surface and wind", {wall(), VectorForce{.field = flow, .strength_n = Strength{0.2}}}, in},
          {"surface and gradient force", {wall(), GradientForce{.field = {"wall"}, .strength_n = Strength{0.2}}}, in},
          {"surface and vortex force", {wall(), VortexForce{.field = flow, .strength_n = Strength{0.2}}}, in},
          {"follow and viscosity", {Follow{.field = flow, .strength_n = strong}, Viscosity{.strength_n = strong}}, across},
          {"five",
           {wall(1.0), Follow{.field = flow, .strength_n = strong}, Viscosity{.strength_n = strong},
            FrontShape{.field = flow, .strength_n = strong}, TransverseDamping{.field = flow, .strength_n = strong}},
           in}};
}

/// [1/s] Growth rate of the swing's logarithm for a mass knocked out of its rest against a holding mode, without a
/// break-through.
double growth_per_s(const Held& held, const Scene& scene, const DevicePlant& plant) {
  constexpr double push_n = 0.5, before_m = 1e-7, knock = 0.05;
  constexpr std::size_t settled_ticks = 50, half_ticks = 200;  // each half holds at least three swings of these masses
  const Similarity map = scene.hand_to_world();
  const Vec3 way = normalized(map.gradient_to_hand(held.way)), from_m = map.to_hand(held.from_m) - before_m * way;
  const auto device =
      released_device(plant, from_m + (1.0 + knock) * push_n / scene.coupling().stiffness_n_per_m * way, push_n * way);
  Session session(scene);
  session.tick({.position_m = from_m}, tick_s);  // before the constraint, so that the proxy meets it
  std::vector<double> along_m;
  run_simulated(session, *device, {.duration_s = (settled_ticks + 2 * half_ticks) * tick_s, .time_ticks = false}, nullptr,
                [&](const TickFrame& frame, const Session&) { along_m.push_back(dot(frame.result.probe_m - from_m, way)); });
  const auto swing_m = [&](auto end) {
    const auto [low, high] = std::minmax_element(end - static_cast<std::ptrdiff_t>(half_ticks), end);
    return *high - *low;
  };
  const auto middle = along_m.end() - static_cast<std::ptrdiff_t>(half_ticks);
  return std::log(swing_m(along_m.end()) / swing_m(middle)) / (half_ticks * tick_s);
}

/// [1/s] Growth rate of the linear loop: ln|z|/T of the oscillating root of
/// (z - 1)(z - e) z^d + k ((T - a)(z - e) + a (1 - e))/b with e = exp(-bT/m) and a = m (1 - e)/b: a damped mass, and a force -k
/// x that is held for a tick and acts d ticks late.
double linear_growth_per_s(const DevicePlant& plant, double stiffness_n_per_m) {
  using Complex = std::complex<double>;
  const double b = plant.damping_ns_per_m, e = std::exp(-b * tick_s / plant.mass_kg), a = plant.mass_kg / b * (1.0 - e);
  const auto value = [&](Complex z) {
    return (z - 1.0) * (z - e) * std::pow(z, plant.delay_ticks) +
           stiffness_n_per_m / b * ((tick_s - a) * (z - e) + a * (1.0 - e));
  };
  Complex z = std::polar(1.0, tick_s * std::sqrt(stiffness_n_per_m / plant.mass_kg)), before = 1.001 * z;
  for (int n = 0; n < 50 && std::abs(z - before) > 1e-14; ++n) {
    const Complex slope = (value(z) - value(before)) / (z - before);
    before = z;
    z -= value(z) / slope;
  }
  EXPECT_LT(std::abs(value(z)), 1e-12);
  return std::log(std::abs(z)) / tick_s;
}

TEST(Check, EveryModeIsStableUpToTheClosedFormBound) {
  // Of the bound; 1.05 is beyond the error of its closed form, a term of bT/m.
  constexpr double stable[] = {0.8, 1.0}, beyond = 1.05;
  for (const Held& held : all_that_hold()) {
    Scene scene = scene_of(held);
    for (const double damping : {2.0, 5.0}) {
      for (const int delay_ticks : {0, 1}) {
        const DevicePlant plant{.mass_kg = 0.1, .damping_ns_per_m = damping, .delay_ticks = delay_ticks};
        const double bound = stiffness_bounds(plant, 0.0, tick_s).stable_n_per_m;
        EXPECT_NEAR(bound, damping / (tick_s * (0.5 + delay_ticks)), 1e-9);
        // Growth rises by b/2m over one bound. Its sub-steps give the device a lead of a hundredth of T/2.
        const double close_per_s = 0.02 * damping / (2.0 * plant.mass_kg);
        const auto expect_linear = [&](double share) {
          scene.edit<CouplingOptions>([&](auto& coupling) { coupling.stiffness_n_per_m = share * bound; });
          const double growth = growth_per_s(held, scene, plant);
          EXPECT_NEAR(growth, linear_growth_per_s(plant, share * bound), close_per_s)
              << held.name << ", b = " << damping << ", " << delay_ticks << " ticks late, " << share << " of the bound";
          return growth;
        };
        for (const double share : stable) EXPECT_LT(expect_linear(share), 0.0) << held.name << ", " << share;
        EXPECT_GT(expect_linear(beyond), 0.0) << held.name;
      }
    }
  }
}

TEST(Check, AHeldWallBringsInWhatTheClosedFormSays) {
  constexpr double k = 800.0, amplitude_m = 0.005;
  const Scene scene = [] {
    Scene strong({.stiffness_n_per_m = k, .damping_ns_per_m = 0.0, .max_force_n = 50.0});
    strong.add("wall", plane_field());
    strong.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
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

Scene ball(double stiffness_n_per_m, double damping_ns_per_m) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = damping_ns_per_m, .max_force_n = 10.0});
  scene.add("ball", sphere_field());
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
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

TEST(Check, LetsADeviceGoBeforeALevelWhereverThatStands) {
  const DevicePlant smooth = device_plant("omega,coulomb_friction_n=0");
  for (const double behind_m : {0.0, 0.0003, 0.0007}) {  // a plane on the steps of the paths, and between them
    Scene scene({.stiffness_n_per_m = 5000.0, .damping_ns_per_m = 0.0, .max_force_n = 12.0});
    scene.add("wall", plane_field());
    scene.set(Workspace{.scale = 1.0, .center_m = Vec3{0.0, 0.0, behind_m}});
    scene.add("wall", SurfaceAndFriction{.field = {"wall"}, .levels = {{.value = 0.0, .strength_n = Strength{20.0}}}});
    const CheckReport report = check_quickly(scene, smooth);
    const auto released = std::find_if(report.findings.begin(), report.findings.end(),
                                       [](const CheckFinding& finding) { return finding.key == "let_go"; });
    ASSERT_NE(released, report.findings.end());
    EXPECT_EQ(released->grade, Grade::stop) << behind_m << "\n" << to_table(report);
  }
}

TEST(Check, LetsASoftSceneBe) {
  const Scene soft = ball(150.0, 0.5);
  const CheckReport report = check(soft, device_plant("omega"));
  EXPECT_EQ(report.grade, Grade::fine) << to_table(report);
  EXPECT_TRUE(report.changes.empty()) << to_table(report);
}

const CheckFinding& finding_of(const CheckReport& report, std::string_view key) {
  return *std::ranges::find(report.findings, key, &CheckFinding::key);
}

// Laboratories' values: 500 N/m, or the device's own maximum if that is less.
TEST(Check, IsFineWithWhatFirstScenesHaveOnTheDevicesThatTheyName) {
  for (const char* device : {"touch", "omega", "falcon", "inverse3"}) {
    const CheckReport report = check(ball(500.0, 0.2), device_plant(device), {.advise = false});
    EXPECT_EQ(report.grade, Grade::fine) << to_table(report);
  }
}

TEST(Check, HasStiffnessesOfEachGrade) {
  std::vector<Grade> grades;
  std::string said;
  for (const double k : {500.0, 800.0, 1000.0, 1200.0, 1400.0, 5000.0}) {
    const CheckReport report = check_quickly(ball(k, 0.2), device_plant("omega"));
    grades.push_back(report.grade);
    said += detail::text("%g: ", k) + report.verdict + "\n";
  }
  EXPECT_EQ(grades.front(), Grade::fine) << said;
  EXPECT_EQ(grades.back(), Grade::stop) << said;
  EXPECT_TRUE(std::ranges::find(grades, Grade::warn) != grades.end()) << said;
}

/// A head whose skin breaks and whose bone holds.
Scene phantom(double stiffness_n_per_m, double damping_ns_per_m) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = damping_ns_per_m, .max_force_n = 7.0});
  scene.add("head", head_phantom());
  scene.edit<Workspace>([&](auto& workspace) { workspace.fit = "head"; });
  scene.add("surface", SurfaceAndFriction{.field = {"head"},
                                          .levels = {{.value = -300.0, .strength_n = Strength{0.8}, .stiffness_n_per_m = 300.0},
                                                     {.value = 300.0, .strength_n = Strength{12.0}}},
                                          .friction_n = 0.1});
  return scene;
}

// At each stiffness the device is tried at the same places in the same directions, so that a stiffer scene is never the better
// one for having been tried elsewhere.
TEST(Check, NeverJudgesAStifferCouplingBetter) {
  for (const char* device : {"omega", "falcon"}) {
    for (Scene (*const of)(double, double) : {ball, phantom}) {
      const DevicePlant plant = device_plant(device);
      std::string said;
      std::vector<CheckPlace> places;
      Grade before = Grade::fine;
      for (const double k : {200.0, 500.0, 900.0, 1300.0, 1800.0, 2500.0, 3000.0}) {
        const CheckReport report = check(of(k, 0.2), plant, {.advise = false});
        said += detail::text("%g: ", k) + report.verdict + "\n";
        EXPECT_GE(report.grade, before) << device << "\n" << said;
        before = report.grade;
        if (places.empty()) places = report.places;
        ASSERT_EQ(report.places.size(), places.size()) << device << ", " << k;
        for (std::size_t p = 0; p < places.size(); ++p) {
          EXPECT_EQ(report.places[p].front_m, places[p].front_m) << device << ", " << k;
          EXPECT_EQ(report.places[p].inwards, places[p].inwards) << device << ", " << k;
        }
      }
    }
  }
}

// From 900 N/m on the loop throws this device off its place within 0.3 s, so that it never rests there.
TEST(Check, CallsADeviceThatItsLoopThrowsOffNotAtRest) {
  const DevicePlant plant = device_plant("omega,coulomb_friction_n=0.05,delay_ticks=2");
  std::string said;
  Grade before = Grade::fine;
  for (const double k : {200.0, 500.0, 900.0, 1300.0, 2500.0}) {
    const CheckReport report = check(phantom(k, 0.2), plant, {.advise = false});
    said += detail::text("%g: ", k) + report.verdict + "\n";
    EXPECT_GE(report.grade, before) << said;
    EXPECT_EQ(report.grade >= Grade::warn, k >= 500.0) << said;
    EXPECT_EQ(report.verdict.find("thrown off") != std::string::npos, k >= 900.0) << said;
    before = report.grade;
  }
}

// The margin is one of friction: a device with half of it hums, or rests, as the margin predicts.
TEST(Check, ItsMarginIsWhatADeviceOfHalfTheFrictionDoes) {
  for (const double k : {500.0, 1000.0, 2000.0}) {
    const CheckReport presumed = check_quickly(ball(k, 0.2), device_plant("omega"));
    const CheckReport smooth = check_quickly(ball(k, 0.2), device_plant("omega,coulomb_friction_n=0.05"));
    EXPECT_EQ(finding_of(presumed, "margin").measured, finding_of(smooth, "let_go").measured) << k;
  }
}

TEST(Check, WhatItProposesMakesItBetter) {
  int proposed = 0;
  for (const char* device : {"touch", "omega", "omega,coulomb_friction_n=0", "touch,delay_ticks=4"}) {
    for (const double k : {400.0, 1200.0}) {
      for (const double damping : {0.2}) {
        const Scene scene = ball(k, damping);
        const DevicePlant plant = device_plant(device);
        const CheckReport report = check(scene, plant);
        const CheckReport as_borne = check(within(scene, checked_plant(plant)), plant, {.advise = false});
        EXPECT_EQ(as_borne.grade, report.grade);
        if (report.changes.empty()) continue;
        const CheckReport after = check(changed(scene, report.changes), plant, {.advise = false});
        EXPECT_EQ(after.grade, report.grade_after) << device << ", " << k << "\n" << to_table(report) << to_table(after);
        const bool searched = std::ranges::any_of(
            report.changes, [](const Change& change) { return change.why.find("made for") == std::string::npos; });
        if (!searched) continue;
        ++proposed;
        EXPECT_TRUE(detail::is_better(after, report)) << device << ", " << k << "\n" << to_table(report) << to_table(after);
      }
    }
  }
  EXPECT_GT(proposed, 1);
}

TEST(Check, SpeaksOfStrengthsOnlyWhereModesPushBeyondTheLimitTogether) {
  const auto stream = [](double strength_n) {
    Scene scene({.stiffness_n_per_m = 500.0, .damping_ns_per_m = 0.2, .max_force_n = 3.3});
    scene.add("wall", plane_field());
    scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
    scene.add("wall", SurfaceAndFriction{.field = {"wall"}, .levels = {{.value = 0.0, .strength_n = Strength{strength_n}}}});
    return scene;
  };
  const auto speaks = [](const CheckReport& report) {
    return std::ranges::any_of(report.advice, [](const std::string& s) { return s.find("strengths") != std::string::npos; });
  };
  Scene both = stream(2.5);
  both.add("honey", Viscosity{.strength_n = Strength{2.5}});
  const CheckReport too_much = check(both, device_plant("omega"));
  EXPECT_EQ(finding_of(too_much, "saturation").grade, Grade::warn) << to_table(too_much);
  EXPECT_TRUE(speaks(too_much)) << to_table(too_much);
  for (const double strength_n : {2.5, 12.0}) {  // pressed through, and holding
    const CheckReport report = check(stream(strength_n), device_plant("omega"));
    EXPECT_EQ(finding_of(report, "saturation").grade, Grade::fine) << to_table(report);
    EXPECT_FALSE(speaks(report)) << to_table(report);
  }
}

TEST(Check, IsTheSameEveryTime) {
  // A plane is uniform, so one point is checked. Without friction nothing holds the device, so that a better setting is
  // searched for.
  Scene scene({.stiffness_n_per_m = 5000.0, .damping_ns_per_m = 0.0, .max_force_n = 12.0});
  scene.add("wall", plane_field());
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  scene.add("wall", SurfaceAndFriction{.field = {"wall"}, .levels = {{.value = 0.0, .strength_n = Strength{20.0}}}});
  const DevicePlant smooth = device_plant("omega,coulomb_friction_n=0");
  const CheckReport once = check(scene, smooth, {.map = true}), again = check(scene, smooth, {.map = true});
  EXPECT_EQ(once.grade, Grade::stop);
  EXPECT_FALSE(once.changes.empty());
  EXPECT_EQ(to_json(once), to_json(again));
  ASSERT_FALSE(once.map.empty());
  ASSERT_EQ(once.map.size(), again.map.size());
  for (std::size_t n = 0; n < once.map.size(); ++n) {
    EXPECT_EQ(once.map[n].stiffness_n_per_m, again.map[n].stiffness_n_per_m);
    EXPECT_EQ(once.map[n].damping_ns_per_m, again.map[n].damping_ns_per_m);
    EXPECT_EQ(once.map[n].grade, again.map[n].grade);
  }
  ASSERT_EQ(once.curve.size(), again.curve.size());
  for (std::size_t n = 0; n < once.curve.size(); ++n) {
    EXPECT_EQ(once.curve[n].alone_n_per_m, again.curve[n].alone_n_per_m);
    EXPECT_EQ(once.curve[n].friction_n_per_m, again.curve[n].friction_n_per_m);
  }
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
  EXPECT_EQ(report.verdict, "no contact within reach of the hand");
}

TEST(Check, ADeviceWithoutMassIsRefused) { EXPECT_THROW((void)check(ball(500.0, 0.2), {.name = "ideal"}), LoadError); }

TEST(Check, IsOfWhatTheDeviceBears) {
  const CheckReport report = check(ball(5000.0, 0.2), device_plant("touch"));
  EXPECT_EQ(report.coupling.stiffness_n_per_m, 400.0);
  EXPECT_EQ(report.coupling.max_force_n, 3.3);
  ASSERT_FALSE(report.changes.empty());
  EXPECT_EQ(report.changes.front().from, 5000.0);
}

// A stick before a wall: it warns where a press tips it over, names the radius that helps, and then is content.
TEST(Check, AToolThatTipsOverIsWarnedOfAndHelped) {
  Scene scene({.stiffness_n_per_m = 400.0, .damping_ns_per_m = 0.5, .max_force_n = 3.0, .max_torque_nm = 0.3});
  scene.add("wall", plane_field());
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  scene.add("skin", SurfaceAndFriction{.field = {"wall"}, .levels = {{.value = 0.0, .strength_n = Strength{2.0}}}});
  ToolOptions stick{.shape = ToolOptions::Shape::points, .points_m = {{0, 0, -0.05}}, .turning_radius_m = 0.01};
  scene.set(stick);
  DevicePlant plant = device_plant("omega");
  const auto finding_of = [](const CheckReport& report, std::string_view key) {
    return *std::ranges::find(report.findings, key, &CheckFinding::key);
  };
  const CheckReport tips = check_quickly(scene, plant);
  EXPECT_EQ(finding_of(tips, "tips").grade, Grade::warn);
  EXPECT_NEAR(finding_of(tips, "tips").threshold, 2.0 * tips.coupling.max_force_n * 0.05, 1e-12);
  EXPECT_THAT(finding_of(tips, "torque").words, HasSubstr("drives no torque"));
  EXPECT_THAT(to_table(tips), HasSubstr("turning    0.04 N·m/rad"));
  stick.turning_radius_m = std::sqrt(finding_of(tips, "tips").threshold / tips.coupling.stiffness_n_per_m);
  scene.set(stick);
  plant.limits.max_torque_nm = 0.4;
  const CheckReport stands = check_quickly(scene, plant);
  EXPECT_EQ(finding_of(stands, "tips").grade, Grade::fine);
  EXPECT_EQ(finding_of(stands, "torque").grade, Grade::fine);
  plant.limits.max_turn_stiffness_nm_per_rad = 0.1;
  EXPECT_NEAR(check_quickly(scene, plant).turning_radius_m, std::sqrt(0.1 / 400.0), 1e-9);
  scene.set(ToolOptions{});
  EXPECT_TRUE(
      std::ranges::none_of(check_quickly(scene, plant).findings, [](const CheckFinding& f) { return f.key == "tips"; }));
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

}  // namespace check_test
}  // namespace palpa
