// Front shape, transverse damping, viscosity and vortex modes in a session: closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/data/filter.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"
#include "tests/mode/vortex_flows.h"

namespace palpa {
namespace modes_felt_test {

constexpr double tick_s = 1e-3;

struct Uniform {
  Vec3 velocity_m_per_s;
  Vec3 velocity(const Vec3&) const { return velocity_m_per_s; }
};

Volume volume_of(FieldPtr field) {
  Volume volume;
  volume.format = "grid";
  volume.fields.push_back({"velocity", "m/s", std::move(field)});
  return volume;
}

/// A scene of one mode in one vector field; a metre of the hand is a metre of the world.
template <class M>
Scene scene_of(const FieldPtr& field, M mode) {
  Scene scene({.stiffness_n_per_m = 500});
  mode.field = scene.add("flow", volume_of(field));
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  scene.add("mode", mode);
  return scene;
}

/// Moves the hand at a velocity until the force is steady; returns the last tick.
Tick led(Session& session, const Vec3& velocity_m_per_s, int ticks) {
  Tick t;
  for (int i = 0; i <= ticks; ++i) t = session.tick({.position_m = tick_s * i * velocity_m_per_s}, tick_s);
  return t;
}

/// A channel with cells a thousand times thinner at the wall: a sub-step's length depends on the cells at the proxy.
TEST(Follow, KeepsUpWithAHandFarFromThinCells) {
  std::array<std::vector<double>, 3> planes_m;
  for (int i = 0; i < 33; ++i) {
    planes_m[0].push_back(0.004 * i);
    planes_m[1].push_back(0.004 * i);
    planes_m[2].push_back(i == 0 ? 0.0 : 0.004 * (i - 1) + 4e-6);
  }
  const auto voxels = std::make_shared<std::vector<float>>();
  for (int i = 0; i < 33 * 33 * 33; ++i) voxels->insert(voxels->end(), {1.0f, 0.0f, 0.0f});
  const FieldPtr flow = grid_field(rectilinear_geometry(planes_m), {VoxelType::float32, 3, {voxels, voxels->data()}});
  Session session(scene_of(flow, Follow{.strength_n = 0.4}));
  for (int i = 0; i < 200; ++i) {
    const Tick t = session.tick({.position_m = {0.06, 0.02 + 0.4 * tick_s * i, 0.06}}, tick_s);
    EXPECT_EQ(t.status, TickStatus::complete) << i;
    EXPECT_LE(norm(t.force_n), 0.4 + 1e-9);
    EXPECT_NEAR(norm(t.proxy_m - t.probe_m), std::min(0.4 / 500, 0.4 * tick_s * i), 1e-9);
  }
}

/// Unsigned directions that differ between neighbours: the field jumps from cell to cell, and a rail may drive the proxy over a
/// jump while the viscosity beyond drives it back. The path continues between them, with hardly any pending motion.
TEST(Follow, GetsOnAlongJumpsOfTheData) {
  test::Random random(5);
  int jumps = 0, waiting = 0, ticks = 0;
  for (int stroke = 0; stroke < 40; ++stroke) {
    const auto voxels = std::make_shared<std::vector<float>>();
    for (int i = 0; i < 41 * 41 * 41; ++i) {
      const Vec3 v = random.direction();
      voxels->insert(voxels->end(), {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
    }
    const GridGeometry grid{{41, 41, 41}, 0.0015 * Mat3::identity(), {-0.03, -0.03, -0.03}};
    const FieldPtr directions = signless(grid_field(grid, {VoxelType::float32, 3, {voxels, voxels->data()}}));
    Scene scene({.stiffness_n_per_m = 500});
    const FieldRef flow = scene.add("flow", volume_of(directions));
    const FieldRef length{"magnitude(flow)"};
    scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
    scene.add("rail", Follow{.field = flow, .strength_n = {length, TransferFunction({{0.3, 0.0}, {0.7, 1.2}, {2.0, 1.2}})}});
    scene.add("fluid", Viscosity{.field = flow, .strength_n = 0.0, .drag_ns_per_m = 1.0},
              {{length, TransferFunction({{0.15, 0.0}, {0.3, 1.0}, {2.0, 1.0}})}});
    Session session(scene);
    const Vec3 from_m = 0.025 * random.direction();
    for (int i = 0; i < 1000; ++i) {
      const Tick t = session.tick({.position_m = (1.0 - i / 500.0) * from_m}, tick_s);
      waiting += t.status != TickStatus::complete;
      ++ticks;
      for (const SubStep& step : session.sub_steps()) jumps += step.stop == Stop::event;
    }
  }
  EXPECT_GT(jumps, 1000) << "nothing sets in";
  EXPECT_LE(waiting, 1e-3 * ticks) << "of " << ticks;
}

/// Random directions from voxel to voxel: no point balances a rail or a front there, and a proxy that searched at each position
/// of the hand would lag for ever (a third to a half of these ticks did).
TEST(Follow, KeepsUpWithTheHandInNoise) {
  test::Random random(5);
  for (const bool is_rail : {true, false}) {
    int waiting = 0, ticks = 0;
    for (int stroke = 0; stroke < 12; ++stroke) {
      const auto voxels = std::make_shared<std::vector<float>>();
      for (int i = 0; i < 41 * 41 * 41; ++i) {
        const Vec3 v = random.direction();
        voxels->insert(voxels->end(), {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
      }
      const GridGeometry grid{{41, 41, 41}, 0.0015 * Mat3::identity(), {-0.03, -0.03, -0.03}};
      const FieldPtr noise = grid_field(grid, {VoxelType::float32, 3, {voxels, voxels->data()}});
      Session session(is_rail ? scene_of(noise, Follow{.strength_n = 3.0}) : scene_of(noise, FrontShape{.strength_n = 8.0}));
      const Vec3 from_m = 0.02 * random.direction();
      for (int i = 0; i < 1000; ++i) {
        waiting += session.tick({.position_m = (1.0 - i / 500.0) * from_m}, tick_s).status != TickStatus::complete;
        ++ticks;
      }
    }
    EXPECT_LE(waiting, 1e-2 * ticks) << (is_rail ? "rail" : "front") << ", of " << ticks;
  }
}

TEST(FrontShape, LetsGoWithTheFlowAndHoldsAgainstIt) {
  test::Random random(1);
  const Vec3 flow = random.direction(), across = normalized(cross(flow, random.direction()));
  const Scene scene = scene_of(test::sampled_anyhow(Uniform{flow}, 0.01, 41, 0.0, random), FrontShape{.strength_n = 0.6});
  Session with(scene), along_the_front(scene), against(scene);
  EXPECT_LT(norm(led(with, 0.1 * flow, 200).force_n), 1e-9);
  EXPECT_LT(norm(led(along_the_front, 0.1 * across, 200).force_n), 1e-6);
  const Tick held = led(against, -0.01 * flow, 50);
  EXPECT_LT(norm(held.proxy_m), 1e-9);
  EXPECT_LT(norm(held.force_n - 500 * 0.5e-3 * flow), 1e-6);
  Session pressed(scene);
  EXPECT_LT(norm(led(pressed, -0.05 * flow, 200).force_n - 0.6 * flow), 1e-6) << "pressed through at the strength";
}

// The proxy lags so far that the spring carries the drag: F = −c v across, after some c/k seconds.
TEST(TransverseDamping, ResistsMotionAcrossInProportionToItsSpeed) {
  test::Random random(2);
  const Vec3 flow = random.direction(), across = normalized(cross(flow, random.direction()));
  const Scene scene =
      scene_of(test::sampled_anyhow(Uniform{flow}, 0.01, 41, 0.0, random), TransverseDamping{.drag_ns_per_m = 4.0});
  for (const double speed : {0.02, 0.05, 0.1}) {
    Session along(scene), sideways(scene), oblique(scene);
    EXPECT_LT(norm(led(along, speed * flow, 200).force_n), 1e-6);
    EXPECT_LT(norm(led(sideways, speed * across, 200).force_n + 4.0 * speed * across), 1e-4 * speed);
    EXPECT_LT(norm(led(oblique, speed * (flow + across), 200).force_n + 4.0 * speed * across), 1e-4 * speed);
  }
}

// Dry: a constant force at any speed, and none at rest. Wet: in proportion to the speed.
TEST(Viscosity, IsDryWithAStrengthAndWetWithADrag) {
  for (const double speed : {0.02, 0.2}) {
    Scene dry({.stiffness_n_per_m = 500}), wet({.stiffness_n_per_m = 500});
    dry.add("mode", Viscosity{.strength_n = 0.5});
    wet.add("mode", Viscosity{.drag_ns_per_m = 3.0});
    Session in_dry(dry), in_wet(wet);
    const Vec3 along{0.6, 0, 0.8};
    EXPECT_LT(norm(led(in_dry, speed * along, 300).force_n + 0.5 * along), 1e-9);
    EXPECT_LT(norm(led(in_wet, speed * along, 300).force_n + 3.0 * speed * along), 1e-6);
    const Vec3 end = tick_s * 300 * speed * along;
    Tick kept, free;
    for (int i = 0; i < 300; ++i) {
      kept = in_dry.tick({.position_m = end}, tick_s);
      free = in_wet.tick({.position_m = end}, tick_s);
    }
    EXPECT_LT(norm(kept.force_n + 0.5 * along), 1e-9);
    EXPECT_LT(norm(free.force_n), 1e-6);
  }
}

test::StraightVortex jet_vortex(test::Random& random) {
  test::StraightVortex vortex{.core_m = 0.01, .axis = random.direction()};
  vortex.jet_m_per_s = vortex.peak_m_per_s();
  vortex.across_m_per_s = vortex.peak_m_per_s() * normalized(cross(vortex.axis, random.direction()));
  return vortex;
}

// Within s/k = 1.6 mm of the core the proxy lies on the core line itself, and along it the hand is free.
TEST(VortexLine, HoldsTheProxyOnTheCoreLine) {
  test::Random random(4);
  const test::StraightVortex vortex = jet_vortex(random);
  const FieldPtr flow = test::sampled_anyhow(vortex, vortex.core_m / 5, 47, 0.01 * vortex.peak_m_per_s(), random);
  Session session(scene_of(flow, VortexLine{.strength_n = 0.8}));
  for (int i = 0; i < 100; ++i) {
    session.reset();
    const Vec3 side = normalized(cross(vortex.axis, random.direction()));
    const Vec3 held = random.uniform(0.1e-3, 1.4e-3) * side, along = 0.004 * vortex.axis;
    Tick t;
    for (int n = 0; n <= 200; ++n) t = session.tick({.position_m = held + n / 200.0 * along}, tick_s);
    for (int n = 0; n < 100; ++n) t = session.tick({.position_m = held + along}, tick_s);
    EXPECT_LT(norm(vortex.radial_m(t.proxy_m)), 0.02 * vortex.core_m);
    EXPECT_LT(std::abs(dot(t.force_n, vortex.axis)), 0.1 * norm(t.force_n) + 1e-3) << "free along the core";
  }
}

// A flow with hardly any rotation has its core beyond any hand's reach: no core, and no fault.
TEST(VortexLine, HasNoCoreBeyondReach) {
  for (const double rate_per_s : {1e-5, 1e-8, 1e-12}) {
    const auto voxels = std::make_shared<std::vector<double>>();
    constexpr int n = 9;
    for (int k = 0; k < n; ++k) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          const Vec3 x = 0.01 * Vec3{i - 4.0, j - 4.0, k - 4.0};
          voxels->insert(voxels->end(), {100.0 - rate_per_s * x.y, rate_per_s * x.x, 0.0});
        }
      }
    }
    const FieldPtr flow = grid_field({{n, n, n}, 0.01 * Mat3::identity(), {-0.04, -0.04, -0.04}},
                                     {VoxelType::float64, 3, {voxels, voxels->data()}});
    Scene scene({.stiffness_n_per_m = 500});
    const FieldRef velocity = scene.add("flow", volume_of(flow));
    scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
    scene.add("core", VortexLine{.field = velocity,
                                 .strength_n = {{"magnitude(flow)"}, TransferFunction({{0.0, 1.0}, {1.0, 1.0}})},
                                 .direction = VortexLine::By::reduced_velocity});
    Session session(scene);
    for (int i = 0; i < 50; ++i) {
      const Tick t = session.tick({.position_m = {1e-4 * i, 2e-4 * i, 0}}, tick_s);
      EXPECT_EQ(t.dropped, 0);
      EXPECT_EQ(t.force_n, Vec3{});
      for (const SessionEvent& event : session.events()) EXPECT_NE(event.kind, SessionEventKind::fault) << event.text;
    }
  }
}

TEST(VortexModes, HoldAStillHandStillWhateverTheyGoBy) {
  test::Random random(5);
  const test::StraightVortex vortex = jet_vortex(random);
  const FieldPtr flow = test::sampled_anyhow(vortex, vortex.core_m / 3, 29, 0.03 * vortex.peak_m_per_s(), random);
  std::vector<Scene> scenes;
  for (const auto d : {VortexDirection::q, VortexDirection::vorticity, VortexDirection::reduced_velocity}) {
    scenes.push_back(scene_of(flow, VortexForce{.strength_n = 1.0, .direction = d}));
    scenes.push_back(scene_of(flow, VortexPlane{.strength_n = 1.0, .direction = d}));
  }
  for (const auto d : {VortexLine::By::q, VortexLine::By::reduced_velocity}) {
    scenes.push_back(scene_of(flow, VortexLine{.strength_n = 1.0, .direction = d}));
  }
  constexpr int places = 100;
  for (const Scene& scene : scenes) {
    Session session(scene);
    double worst_n = 0.0;
    int felt = 0;
    for (int i = 0; i < places; ++i) {
      session.reset();
      const Vec3 held = random.uniform(0.0, 1.5) * vortex.core_m * random.direction(), from = held + 0.02 * random.direction();
      Vec3 low{1e9, 1e9, 1e9}, high = -low;
      for (int n = 0; n < 320; ++n) {
        const Tick t = session.tick({.position_m = from + std::min(1.0, n / 200.0) * (held - from)}, tick_s);
        if (n < 300) continue;
        low = {std::min(low.x, t.force_n.x), std::min(low.y, t.force_n.y), std::min(low.z, t.force_n.z)};
        high = {std::max(high.x, t.force_n.x), std::max(high.y, t.force_n.y), std::max(high.z, t.force_n.z)};
        felt += n == 319 && norm(t.force_n) > 1e-3;
      }
      worst_n = std::max(worst_n, norm(high - low));
    }
    EXPECT_GT(felt, places / 5) << scene.modes()[0].mode.type();
    EXPECT_LT(worst_n, 1e-3) << scene.modes()[0].mode.type();
  }
}

}  // namespace modes_felt_test
}  // namespace palpa
