// Feel a head: two levels of one field, and friction.
//
// The hand presses on the forehead of the built-in head with less than the skin's strength, and moves sideways: friction drags
// on it with at most 0.1 N. Then it presses harder: it breaks through the skin, and the bone stops it.
#include <palpa/palpa.h>

#include <algorithm>
#include <cstdio>

int main() {
  palpa::Scene scene({.stiffness_n_per_m = 400, .max_force_n = 5});
  const palpa::FieldRef head = scene.add("head", palpa::head_phantom());
  scene.add("surface", palpa::SurfaceAndFriction{.field = head,
                                                 .levels = {{.name = "skin", .value = -300, .strength_n = 0.8},
                                                            {.name = "bone", .value = 300, .strength_n = 4.0}},
                                                 .friction_n = 0.1});
  palpa::Session session(scene);

  // In the world of a head x is the patient's left, y the back, z the crown.
  const palpa::Similarity map = session.hand_to_world();
  const palpa::Vec3 inwards = map.direction_to_hand({0, 1, 0});
  const palpa::Vec3 sideways = map.direction_to_hand({1, 0, 0});
  palpa::Vec3 hand_m = map.to_hand({0, -0.12, 0.05});

  bool skin_met = false, bone_met = false, skin_gave = false, bone_gave = false;
  const auto feel = [&] {
    const palpa::Tick tick = session.tick({.position_m = hand_m}, 1e-3);
    for (const palpa::SessionEvent& event : session.events()) {
      const bool gave = event.kind == palpa::SessionEventKind::break_through;
      if (!gave && event.kind != palpa::SessionEventKind::onset) continue;
      const bool bone = event.value > 0;
      std::printf("%s %s\n", bone ? "bone" : "skin", gave ? "gives" : "touched");
      (gave ? (bone ? bone_gave : skin_gave) : (bone ? bone_met : skin_met)) = true;
    }
    return tick;
  };
  const auto move = [&](const palpa::Vec3& step_m) { return hand_m += step_m, feel(); };

  while (!skin_met && dot(hand_m, inwards) < 0.1) move(2e-5 * inwards);
  palpa::Tick pressed;
  while (norm(pressed.force_n) < 0.5 && !skin_gave) pressed = move(2e-5 * inwards);

  double drag_n = 0.0;
  for (int i = 0; i < 200; ++i) drag_n = std::max(drag_n, -dot(move(1e-5 * sideways).force_n - pressed.force_n, sideways));
  std::printf("pressed with %.2f N and moved sideways: a drag of %.3f N\n", norm(pressed.force_n), drag_n);
  const bool rubbed = drag_n > 0.05 && drag_n < 0.12 && !skin_gave;  // the skin is curved: not exactly 0.1 N

  double stopped_n = 0.0;
  while (stopped_n < 2.0 && !bone_gave && dot(hand_m, inwards) < 0.1) {
    const double force_n = norm(move(2e-5 * inwards).force_n);
    stopped_n = bone_met ? force_n : 0.0;
  }
  std::printf("pressed with %.2f N on the bone\n", stopped_n);
  return rubbed && skin_gave && bone_met && !bone_gave && stopped_n >= 2.0 ? 0 : 1;
}
