// Scenes and hands for the tests of far hands.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/device/hand.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/load_scene.h"
#include "palpa/serve/linked_hand.h"
#include "palpa/study/reach.h"

namespace palpa::test {

/// The shipped scenes that need no file.
inline std::vector<std::string> phantoms() {
  return {"beat_phantom", "flow_phantom", "head_phantom", "heart_phantom", "many_phantom", "wing_phantom"};
}
inline Scene phantom(const std::string& name) {
  return load_scene(std::filesystem::path(PALPA_SCENES_FOLDER) / (name + ".toml")).scene;
}

/// Positions [m] of a rigid hand, a millisecond apart.
inline std::vector<Vec3> positions_m(const std::string& hand, double duration_s, const Encounter& met = {}) {
  const auto device = hand_device(simulated_target(simulated_motion(hand), met), Hold::rigid);
  std::vector<Vec3> positions;
  for (double t_s = 0.0; t_s < duration_s; t_s += 1e-3) {
    positions.push_back(device->read().position_m);
    device->write({});
    device->advance(1e-3);
  }
  return positions;
}

/// Where a stroking hand meets the data of a scene.
inline Encounter encounter_of(const Scene& scene) {
  return Reach(scene).encounter({.kind = SimulatedMotion::Kind::stroke}, Hold::rigid);
}

/// A flat wall at z = 0, with friction.
inline Scene flat_wall(double friction_coefficient = 0.0, double stiffness_n_per_m = 500.0) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .max_force_n = 20.0});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
  const FieldRef wall = scene.add("wall", plane_field());
  scene.add("surface",
            SurfaceAndFriction{
                .field = wall, .levels = {{.value = 0.0, .strength_n = 18.0}}, .friction_coefficient = friction_coefficient});
  return scene;
}

}  // namespace palpa::test
