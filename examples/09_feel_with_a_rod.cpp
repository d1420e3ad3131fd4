// Feel with a rod: force and torque of a tool with two feet.
//
// A rod of 80 mm is pressed flat on a wall and then tilted in the hand. Both its ends stay on the wall, so the hand feels k ·
// depth and, against the tilt, the rotational stiffness times the angle. Where the torque is the force times half of the rod's
// length, an end lifts: from there on the rod turns with the hand.
#include <palpa/palpa.h>

#include <cmath>
#include <cstdio>

int main() {
  constexpr double stiffness_n_per_m = 400.0, half_m = 0.04, depth_m = 0.004;
  constexpr double turning_radius_m = 0.04;
  constexpr double stiffness_nm_per_rad = stiffness_n_per_m * turning_radius_m * turning_radius_m;

  palpa::Scene scene({.stiffness_n_per_m = stiffness_n_per_m});
  scene.set(palpa::ToolOptions{.shape = palpa::ToolOptions::Shape::points,
                               .points_m = {{-half_m, 0, 0}, {half_m, 0, 0}},
                               .turning_radius_m = turning_radius_m});
  const palpa::FieldRef wall = scene.add("wall", palpa::plane_field());
  scene.add("surface", palpa::SurfaceAndFriction{.field = wall, .levels = {{.value = 0.0, .strength_n = 10.0}}});
  palpa::Session session(scene);

  const palpa::Similarity map = session.hand_to_world();
  const palpa::Vec3 wall_m = map.to_hand({0, 0, 0}), into_wall = map.direction_to_hand({0, 0, -1});
  const palpa::Vec3 axis = cross(into_wall, palpa::Vec3{1, 0, 0});  // across the rod, along the wall
  for (int i = -100; i <= 400; ++i) session.tick({.position_m = wall_m + 1e-5 * i * into_wall}, 1e-3);

  const double lifts_rad = stiffness_n_per_m * depth_m * half_m / stiffness_nm_per_rad;
  std::puts("tilt of the hand   tilt of the rod     force      torque");
  bool as_stated = true;
  for (int i = 0; i <= 150; ++i) {
    const double tilt_rad = 1e-3 * i;
    const palpa::Tick tick =
        session.tick({.position_m = wall_m + depth_m * into_wall, .turn = palpa::turn_by(tilt_rad * axis)}, 1e-3);
    const double rod_rad = norm(palpa::rotation_rad(tick.proxy_turn)), torque_nm = -dot(tick.torque_nm, axis);
    if (i % 15 == 0) std::printf("%12.3f rad %13.3f rad %7.3f N %8.4f N·m\n", tilt_rad, rod_rad, norm(tick.force_n), torque_nm);

    if (tilt_rad < lifts_rad - 1e-3) {
      as_stated &= rod_rad < 1e-6 && std::abs(norm(tick.force_n) - stiffness_n_per_m * depth_m) < 1e-6;
      as_stated &= std::abs(torque_nm - stiffness_nm_per_rad * tilt_rad) < 1e-6;
    } else if (tilt_rad > lifts_rad + 1e-3) {
      as_stated &= rod_rad > 1e-6 && rod_rad < tilt_rad;
    }
  }
  std::printf(as_stated ? "Both ends stayed on the wall up to %.3f rad.\n" : "The rod did not feel as stated (%.3f rad)!\n",
              lifts_rad);
  return as_stated ? 0 : 1;
}
