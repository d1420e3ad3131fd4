// Resting hands in walls, corners, grooves and on rails, with samples so dense that a glitch or a fast stroke exceeds a tick's
// budget.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/scene.h"
#include "palpa/session/session.h"
#include "tests/solver/random_problems.h"

namespace palpa::test {

constexpr double resting_n_per_m = 400.0;
constexpr std::array resting_rates_hz = {100.0, 150.0, 250.0, 1000.0, 4000.0, 10000.0};

/// [m] depth behind the last of some planes through the origin, with normals out of the solid: the union of their solids.
class Walls final : public Field {
 public:
  Walls(std::vector<Vec3> normals, double spacing_m) : normals_(std::move(normals)), spacing_m_(spacing_m) {}
  int components() const noexcept override { return 1; }
  ScalarSample scalar(const Vec3& at_m) const noexcept override {
    const auto behind = [&](const Vec3& a, const Vec3& b) { return dot(a, at_m) > dot(b, at_m); };
    const Vec3& n = *std::max_element(normals_.begin(), normals_.end(), behind);
    return {-dot(n, at_m), -n, true};
  }
  double spacing_m() const noexcept override { return spacing_m_; }
  Box bounds_m() const noexcept override { return {{-9, -9, -9}, {9, 9, 9}}; }
  double depth_m(const Vec3&) const noexcept override { return 1.0; }
  std::vector<ValueRange> value_ranges() const override { return {{-9.0, 9.0}}; }

 private:
  std::vector<Vec3> normals_;
  double spacing_m_;
};

class Stream final : public Field {
 public:
  explicit Stream(double spacing_m) : spacing_m_(spacing_m) {}
  int components() const noexcept override { return 3; }
  VectorSample vector(const Vec3&) const noexcept override { return {{0.6, 0.8, 0.0}, {}, true}; }
  double spacing_m() const noexcept override { return spacing_m_; }
  Box bounds_m() const noexcept override { return {{-9, -9, -9}, {9, 9, 9}}; }
  double depth_m(const Vec3&) const noexcept override { return 1.0; }
  std::vector<ValueRange> value_ranges() const override { return {{0.6, 0.6}, {0.8, 0.8}, {0.0, 0.0}}; }

 private:
  double spacing_m_;
};

/// A hand that has come slowly `from_m` [m] and rests at `at_m` [m].
struct RestingHand {
  std::string name;
  Scene scene;
  Vec3 from_m, at_m;
  Vec3 held_n;  // the walls' holding force, after any history; 0: depends on the path
};

inline FieldRef add_field(Scene& scene, const std::string& name, FieldPtr field) {
  Volume volume;
  volume.fields.push_back({"value", "", std::move(field)});
  return scene.add(name, volume);
}

inline std::vector<RestingHand> resting_hands(double spacing_m, double damping_ns_per_m = 0.0) {
  const auto scene = [&](auto&&... modes) {
    Scene made({.stiffness_n_per_m = resting_n_per_m, .damping_ns_per_m = damping_ns_per_m, .max_force_n = 3.3});
    made.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
    (modes(made), ...);
    return made;
  };
  const auto wall = [&](std::vector<Vec3> normals, double coefficient = 0.0, double viscous_ns_per_m = 0.0) {
    return [=](Scene& made) {
      const std::string name = "wall" + std::to_string(made.modes().size());
      made.add(name, SurfaceAndFriction{.field = add_field(made, name + "_data", std::make_shared<Walls>(normals, spacing_m)),
                                        .levels = {{.value = 0.0, .strength_n = 1000.0}},
                                        .friction_coefficient = coefficient,
                                        .friction_ns_per_m = viscous_ns_per_m});
    };
  };
  const auto rail = [&](double drag_ns_per_m) {
    return [=](Scene& made) {
      made.add("rail", Follow{.field = add_field(made, "stream", std::make_shared<Stream>(spacing_m)),
                              .strength_n = 1.2,
                              .drag_ns_per_m = drag_ns_per_m});
    };
  };
  const auto syrup = [&](double strength_n, double drag_ns_per_m) {
    return [=](Scene& made) {
      made.add("syrup", Viscosity{.field = add_field(made, "air", std::make_shared<Stream>(spacing_m)),
                                  .strength_n = strength_n,
                                  .drag_ns_per_m = drag_ns_per_m});
    };
  };
  constexpr double k = resting_n_per_m, deep_m = 0.003;
  const Vec3 above_m{0, 0, 0.01}, in_wall_m{0, 0, -deep_m}, wall_n{0, 0, k * deep_m}, z{0, 0, 1};
  const double half = 0.5 * std::sqrt(3.0);
  std::vector<RestingHand> hands;
  hands.push_back({"wall", scene(wall({z})), above_m, in_wall_m, wall_n});
  hands.push_back({"wall in drag", scene(wall({z}), syrup(0.0, 2.0)), above_m, in_wall_m, {}});
  hands.push_back({"wall in viscosity", scene(wall({z}), syrup(0.2, 0.0)), above_m, in_wall_m, {}});
  hands.push_back({"friction", scene(wall({z}, 0.5)), above_m, in_wall_m, {}});
  hands.push_back({"friction with drag", scene(wall({z}, 0.3, 2.0)), above_m, in_wall_m, {}});
  const Vec3 in_corner_m{-0.002, -0.001, -deep_m};
  hands.push_back(
      {"corner", scene(wall({{1, 0, 0}}), wall({{0, 1, 0}}), wall({z})), {0.01, 0.01, 0.01}, in_corner_m, -k * in_corner_m});
  hands.push_back({"groove", scene(wall({{half, 0, 0.5}, {-half, 0, 0.5}})), above_m, in_wall_m, wall_n});
  hands.push_back({"rail", scene(rail(0.0)), {}, {0.001, -0.002, 0.003}, {}});
  hands.push_back({"rail with drag", scene(rail(1.0)), {}, {0.001, -0.002, 0.003}, {}});
  return hands;
}

/// Directions of glitches: along the axes and between them.
inline std::vector<Vec3> all_directions() {
  std::vector<Vec3> directions;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const Vec3 way{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
        if (way != Vec3{}) directions.push_back(normalized(way));
      }
    }
  }
  return directions;
}

/// Growth of a force [N] over the last force along the last one's direction.
inline double grown_n(const Vec3& force_n, const Vec3& last_n) {
  const double now_n = norm(force_n);
  return now_n > 0.0 ? now_n - std::max(0.0, dot(force_n, last_n) / now_n) : 0.0;
}

}  // namespace palpa::test
