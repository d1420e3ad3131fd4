// Forces at the edges of holes in the data.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/mode/parameters.h"
#include "palpa/session/session.h"

namespace palpa {
namespace holes_test {

constexpr double dt = 1e-3, speed_m_per_s = 0.05, pressed_m = 2e-3;
constexpr double most_n_per_ms = 0.1;

constexpr std::int64_t n = 65;
constexpr double voxel_m = 1e-3;

Volume volume_of(int components, double hole_voxels) {
  const auto values = std::make_shared<std::vector<float>>();
  for (std::int64_t k = 0; k < n; ++k) {
    for (std::int64_t j = 0; j < n; ++j) {
      for (std::int64_t i = 0; i < n; ++i) {
        const double x = static_cast<double>(i) - 32.0, y = static_cast<double>(j) - 32.0, z = static_cast<double>(k) - 32.0;
        const bool missing = std::hypot(x, y, 0.5 * z) < hole_voxels;
        const auto value = [&](double v) { return missing ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(v); };
        // Level 0 of the scalar is the plane z = 0, solid below; the vector is along x.
        if (components == 1) values->push_back(value(-z));
        if (components == 3) values->insert(values->end(), {value(1.0), value(0.2), value(0.0)});
      }
    }
  }
  const GridGeometry geometry{{n, n, n}, {{{voxel_m, 0, 0}, {0, voxel_m, 0}, {0, 0, voxel_m}}}, {-0.032, -0.032, -0.032}};
  const Voxels voxels{VoxelType::float32, components, {values, values->data()}};
  Volume volume;
  volume.fields.push_back({"f", "", grid_field(geometry, voxels)});
  return volume;
}

Scene scene_with(double hole_voxels) {
  Scene scene({.stiffness_n_per_m = 500, .damping_ns_per_m = 0});
  scene.add("s", volume_of(1, hole_voxels));
  scene.add("v", volume_of(3, hole_voxels));
  scene.edit<Workspace>([&](auto& workspace) { workspace.scale = 1.0; });
  return scene;
}

struct Slide {
  double worst_n = 0.0, largest_n = 0.0, at_m = 0.0;
  int breaks = 0;
};

/// Slides along x through the hole, pressed into the plane, and a little beside its middle.
Slide slide(const Scene& scene, double from_m = -0.028, double to_m = 0.028) {
  Session session(scene);
  Slide slid;
  Vec3 last_n;
  for (int i = 0; i < 100; ++i) {
    const double share = (i + 1) / 100.0;
    last_n = session.tick({.position_m = {from_m, 1.3e-3, 2e-3 - share * (2e-3 + pressed_m)}}, dt).force_n;
  }
  for (int i = 0; from_m + i * speed_m_per_s * dt < to_m; ++i) {
    const double x = from_m + i * speed_m_per_s * dt;
    const Tick tick = session.tick({.position_m = {x, 1.3e-3, -pressed_m}}, dt);
    const double step_n = norm(tick.force_n - last_n);
    if (step_n > slid.worst_n) slid.worst_n = step_n, slid.at_m = x;
    for (const SessionEvent& event : session.events()) slid.breaks += event.kind == SessionEventKind::break_through;
    slid.largest_n = std::max(slid.largest_n, norm(tick.force_n));
    last_n = tick.force_n;
  }
  return slid;
}

struct OneMode {
  const char* name;
  Mode mode;
};

std::vector<OneMode> modes() {
  return {{"surface", SurfaceAndFriction{.field = {"s"}, .levels = {{.name = "skin", .value = 0.0, .strength_n = 3.0}}}},
          {"rough",
           SurfaceAndFriction{
               .field = {"s"}, .levels = {{.name = "skin", .value = 0.0, .strength_n = 3.0}}, .friction_coefficient = 0.3}},
          {"material",
           SurfaceAndFriction{.field = {"s"}, .strength_n = {{"s"}, TransferFunction{{{0.0, 0.0}, {1.0, 3.0}, {100.0, 3.0}}}}}},
          {"gradient", GradientForce{.field = {"s"}, .strength_n = 1.0}},
          {"vector", VectorForce{.field = {"v"}, .strength_n = 1.0}},
          {"follow", Follow{.field = {"v"}, .strength_n = 1.0}},
          {"damping", TransverseDamping{.field = {"v"}}},
          {"viscosity", Viscosity{.field = {"s"}, .drag_ns_per_m = 4.0}}};
}

// Of a hole of one voxel, some, and many.
TEST(Holes, AreSlidThroughWithoutAKick) {
  for (const double hole_voxels : {0.5, 3.0, 9.0}) {
    for (const OneMode& one : modes()) {
      Scene scene = scene_with(hole_voxels);
      scene.add(one.name, one.mode);
      const Slide slid = slide(scene);
      EXPECT_LE(slid.worst_n, most_n_per_ms) << one.name << ", " << hole_voxels << ", at " << slid.at_m;
      EXPECT_GT(slid.largest_n, 0.1) << one.name;
      EXPECT_EQ(slid.breaks, 0) << one.name << ": what data end is no break-through";
    }
  }
}

// The face of the box is an edge like any other: a fading level yields, without a break-through event.
TEST(Holes, AreNoOtherThanTheFacesOfTheBox) {
  for (const OneMode& one : modes()) {
    Scene scene = scene_with(0.0);
    scene.add(one.name, one.mode);
    const Slide slid = slide(scene, 0.0, 0.036);
    EXPECT_LE(slid.worst_n, most_n_per_ms) << one.name << ", at " << slid.at_m;
    EXPECT_GT(slid.largest_n, 0.1) << one.name;
    EXPECT_EQ(slid.breaks, 0) << one.name;
  }
}

}  // namespace holes_test
}  // namespace palpa
