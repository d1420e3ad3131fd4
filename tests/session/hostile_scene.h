// Scenes and hands of maximal work.
#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "palpa/data/grid.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/scene.h"
#include "tests/session/hands.h"

namespace palpa::test {

inline FieldPtr noise(Random& random, int components, double spacing_m, bool smooth, double holes = 0.0) {
  constexpr int n = 40;
  const auto voxels = std::make_shared<std::vector<float>>();
  for (int i = 0; i < n * n * n * components; ++i) {
    const bool is_hole = random.uniform(0, 1) < holes;
    voxels->push_back(is_hole ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(random.uniform(-1, 1)));
  }
  const double corner_m = -0.5 * (n - 1) * spacing_m;
  const GridGeometry grid{{n, n, n}, spacing_m * Mat3::identity(), {corner_m, corner_m, corner_m}};
  const Voxels given{VoxelType::float32, components, {voxels, voxels->data()}};
  return smooth ? smooth_grid_field(grid, given) : grid_field(grid, given);
}

/// Many modes in noise whose voxels are much smaller than the hand's steps.
inline Scene hostile_scene(Random& random, double stiffness_n_per_m) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = random.uniform(0, 1) < 0.5 ? 0.0 : 0.5});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  const double spacing_m = std::exp(random.uniform(std::log(2e-4), std::log(2e-3)));
  const auto newtons = [&] { return random.uniform(0.1, 3.0); };
  for (int i = 0; i < 4; ++i) {
    const std::string of = std::to_string(i);
    const bool smooth = random.uniform(0, 1) < 0.5;
    Volume values, flow;
    values.format = flow.format = "grid";
    values.fields.push_back({"value", "", noise(random, 1, spacing_m, smooth, i == 3 ? 0.02 : 0.0)});
    flow.fields.push_back({"velocity", "m/s", noise(random, 3, spacing_m, smooth)});
    const FieldRef phi = scene.add("values" + of, values), u = scene.add("flow" + of, flow);
    const FieldRef length{"magnitude(flow" + of + ")"};
    scene.add("surface" + of,
              SurfaceAndFriction{.field = phi,
                                 .levels = {{.value = 0.2, .strength_n = newtons()},
                                            {.value = -0.3, .strength_n = newtons(), .stiffness_n_per_m = 300.0}},
                                 .friction_coefficient = 0.3});
    scene.add("length" + of, SurfaceAndFriction{.field = length, .levels = {{.value = 0.7, .strength_n = newtons()}}});
    scene.add("rail" + of, Follow{.field = u, .strength_n = newtons(), .drag_ns_per_m = 0.5});
    scene.add("push" + of, VectorForce{.field = u, .strength_n = {length, TransferFunction({{0.0, 0.0}, {1.0, newtons()}})}});
  }
  return scene;
}

class HostileHand {
 public:
  explicit HostileHand(Random& random) : random_(random), wander_(random, 0.02) {}
  Vec3 next() {
    ++tick_;
    return random_.uniform(0, 1) < 0.05 ? random_.in_cube(0.05) : wander_.at(2e-3 * tick_);
  }

 private:
  Random& random_;
  Wander wander_;
  int tick_ = 0;
};

}  // namespace palpa::test
