// Tools in closed-form solids: scenes, shapes and hands of the tests of tools.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "palpa/mode/modes.h"
#include "palpa/session/session.h"
#include "tests/path/shapes.h"

namespace palpa::tools_test {

using test::formula;
using Shape = ToolOptions::Shape;

inline constexpr double dt = 1e-3;
inline constexpr double k = 500.0;
inline constexpr double strong_n = 1000.0;

// ---- solids: depth above 0 inside ----

inline ScalarSample half_space(const Vec3& x_m, const Vec3& out) { return {-dot(out, x_m), -1.0 * out, true}; }

inline FieldPtr plane(const Vec3& out = {0, 1, 0}) {
  return formula([out](const Vec3& x_m) { return half_space(x_m, out); }, 0.8, 1e-3);
}

inline FieldPtr ball(double radius_m) {
  return formula(
      [radius_m](const Vec3& x_m) {
        return ScalarSample{radius_m - norm(x_m), -1.0 * normalized(x_m), true};
      },
      0.8, 1e-3);
}

// A cylindrical hole about z through a block.
inline FieldPtr hole(double radius_m) {
  return formula(
      [radius_m](const Vec3& x_m) {
        const Vec3 across{x_m.x, x_m.y, 0.0};
        return ScalarSample{norm(across) - radius_m, normalized(across), true};
      },
      0.8, 1e-3);
}

// A ridge of 90° along z, its edge up.
inline FieldPtr ridge() {
  return formula(
      [](const Vec3& x_m) {
        return half_space(x_m, normalized(Vec3{x_m.x < 0.0 ? -1.0 : 1.0, 1.0, 0.0}));
      },
      0.8, 1e-3);
}

struct ToolSetting {
  double kappa = 0.5;  // [N·m/rad]
  double strength_n = strong_n;
  double friction_n = 0.0;
  double friction_coefficient = 0.0;
  double share = 1.0;
  double damping_ns_per_m = 0.0;
  double radius_m() const { return std::sqrt(kappa / k); }
};

inline Scene tool_scene(const FieldPtr& field, ToolOptions tool, const ToolSetting& setting = {}) {
  Scene scene = test::plain_scene(
      {.stiffness_n_per_m = k, .damping_ns_per_m = setting.damping_ns_per_m, .max_force_n = 100.0, .max_torque_nm = 10.0});
  const FieldRef solid = scene.add("solid", test::volume_of(field), {}, test::filter_of(*field));
  scene.add("surface", SurfaceAndFriction{.field = solid,
                                          .levels = {{.name = "skin", .value = 0.0, .strength_n = setting.strength_n}},
                                          .friction_n = setting.friction_n,
                                          .friction_coefficient = setting.friction_coefficient});
  tool.turning_radius_m = setting.radius_m();
  tool.share = setting.share;
  scene.set(tool);
  return scene;
}

inline ToolOptions points(std::vector<Vec3> at) { return {.shape = Shape::points, .points_m = std::move(at)}; }
inline ToolOptions rod(double length_m, int feet) { return {.shape = Shape::rod, .length_m = length_m, .points = feet}; }
inline ToolOptions pad(double radius_m, int feet) { return {.shape = Shape::pad, .radius_m = radius_m, .points = feet}; }

inline Tick felt(Session& session, const Pose& device) {
  return session.tick({.position_m = device.position_m, .turn = device.turn}, dt);
}

// Moves the device in a straight way to a pose, in `ticks` ticks, and keeps it there for as many.
inline Tick go(Session& session, const Pose& from, const Pose& to, int ticks) {
  Tick last;
  for (int i = 1; i <= 2 * ticks; ++i) {
    const double share = std::min(1.0, static_cast<double>(i) / ticks);
    last = felt(session, {from.position_m + share * (to.position_m - from.position_m),
                          turned_further(from.turn, share * rotation_between_rad(from.turn, to.turn))});
  }
  return last;
}

inline Vec3 tilt_rad(const Tick& tick) { return rotation_rad(tick.proxy_turn); }

inline double deepest_m(const Field& solid, const Tool& tool, const Tick& tick) {
  double deepest = -1.0;
  for (std::size_t foot = 0; foot < tool.feet(); ++foot)
    deepest = std::max(deepest, solid.scalar(tool.foot_m({tick.proxy_m, tick.proxy_turn}, foot)).value);
  return deepest;
}

}  // namespace palpa::tools_test
