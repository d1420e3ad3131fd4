// Feel a plane: the whole library in one scene, one session, one loop.
//
// The hand is pushed into a wall with a strength of 1.2 N. With a coupling of 400 N/m the proxy stays on the wall for 3 mm, and
// the force is k · depth; then the hand breaks through.
#include <palpa/palpa.h>

#include <cmath>
#include <cstdio>

int main() {
  constexpr double stiffness_n_per_m = 400.0;
  constexpr double strength_n = 1.2;

  palpa::Scene scene({.stiffness_n_per_m = stiffness_n_per_m});
  const palpa::FieldRef wall = scene.add("wall", palpa::plane_field());
  scene.add("surface", palpa::SurfaceAndFriction{.field = wall, .levels = {{.value = 0.0, .strength_n = strength_n}}});
  palpa::Session session(scene);

  // The session maps the hand's workspace into the world of the data: the wall is the world's plane z = 0.
  const palpa::Similarity map = session.hand_to_world();
  const palpa::Vec3 wall_m = map.to_hand({0, 0, 0});
  const palpa::Vec3 into_wall = map.direction_to_hand({0, 0, -1});

  std::puts("depth of the hand   depth of the proxy     force");
  bool as_stated = true;
  for (int i = -100; i <= 500; ++i) {
    const double depth_m = 1e-5 * i;  // 10 um per millisecond: 1 cm/s
    const palpa::Tick tick = session.tick({.position_m = wall_m + depth_m * into_wall}, 1e-3);
    const double proxy_depth_m = dot(tick.proxy_m - wall_m, into_wall);
    const double force_n = norm(tick.force_n);
    if (i % 50 == 0) std::printf("%14.2f mm %17.2f mm %7.3f N\n", 1e3 * depth_m, 1e3 * proxy_depth_m, force_n);

    const double pull_n = stiffness_n_per_m * depth_m;
    if (std::abs(pull_n - strength_n) < 0.01) continue;  // the tick of the break-through
    const bool held = pull_n > 0.0 && pull_n < strength_n;
    as_stated &= std::abs(force_n - (held ? pull_n : 0.0)) < 1e-6;
  }
  std::puts(as_stated ? "The wall held until 1.2 N." : "The wall did not feel as stated!");
  return as_stated ? 0 : 1;
}
