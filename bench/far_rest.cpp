// Largest stiffness at which a far hand that holds still rests, by delay, and the energy that a fast impact gives it.
//
//   bench_far_rest SCENE HAND [TIME_S [DEVICE]]
//
// The hand goes from the beginning of HAND to its place at TIME_S, relaxed, with DEVICE or an ideal one, and stays there; the
// impact is with a Touch.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "palpa/device/hand.h"
#include "palpa/scene/load_scene.h"
#include "palpa/serve/linked_hand.h"

using namespace palpa;

namespace {

constexpr double most_swing_m = 0.1e-3;

Scene stiffer(Scene scene, double stiffness_n_per_m) {
  scene.edit<CouplingOptions>([&](auto& coupling) { coupling.stiffness_n_per_m = stiffness_n_per_m; });
  return scene;
}

// Way of a hand that goes to a place and stays there.
std::shared_ptr<const Target> held(const Vec3& from_m, const Vec3& to_m, double speed_m_per_s) {
  std::vector<Vec3> way_m;
  const double all_m = distance(from_m, to_m);
  for (double gone_m = 0.0; gone_m < all_m; gone_m += 1e-3 * speed_m_per_s)
    way_m.push_back(from_m + gone_m / all_m * (to_m - from_m));
  way_m.resize(way_m.size() + 4000, to_m);
  return sampled_target(way_m, 1e-3);
}

struct Felt {
  double swing_m = 0.0, gained_j = 0.0, step_n = 0.0, deepest_m = 0.0;
};

Felt felt(const Scene& scene, const std::shared_ptr<const Target>& target, Hold hold, const DevicePlant& plant,
          const LinkOptions& link) {
  const auto device = hand_device(target, hold, plant);
  HandSideOptions options{.device = device->limits(), .motors = false};
  LinkedHand linked(scene, link, options);
  Felt felt;
  Vec3 low_m{1e9, 1e9, 1e9}, high_m{-1e9, -1e9, -1e9}, last_m, last_n, sent_n;
  const auto ticks = static_cast<std::size_t>(1000.0 * target->duration_s());
  double work_j = 0.0, least_j = 0.0;
  for (std::size_t n = 0; n < ticks; ++n) {
    const DeviceState state = device->read();
    const HandTick tick = linked.tick({.position_m = state.position_m, .valid = state.valid});
    device->write(tick.command_n);
    device->advance(1e-3);
    if (n > 0) {
      const Vec3 step_m = state.position_m - last_m;
      work_j += dot(sent_n, step_m);
      least_j = std::min(least_j, work_j);
      felt.gained_j = std::max(felt.gained_j, work_j);
      felt.step_n = std::max(felt.step_n, distance(tick.command_n, last_n) - scene.coupling().stiffness_n_per_m * norm(step_m));
    }
    last_m = state.position_m, last_n = sent_n = tick.command_n;
    if (n + 1000 < ticks) continue;
    const Vec3& x = state.position_m;
    low_m = {std::min(low_m.x, x.x), std::min(low_m.y, x.y), std::min(low_m.z, x.z)};
    high_m = {std::max(high_m.x, x.x), std::max(high_m.y, x.y), std::max(high_m.z, x.z)};
  }
  felt.swing_m = distance(low_m, high_m);
  return felt;
}

void measure(int argc, char** argv) {
  const Scene scene = load_scene(argv[1]).scene;
  const auto path = open_hand(argv[2], Hold::rigid);
  const double at_s = argc > 3 ? std::atof(argv[3]) : 2.0;
  const Vec3 from_m = path->read().position_m;
  for (double t_s = 0.0; t_s < at_s; t_s += 1e-3) path->write({}), path->advance(1e-3);
  const Vec3 to_m = path->read().position_m;
  const DevicePlant plant = argc > 4 ? device_plant(argv[4]) : DevicePlant{};
  for (const double delay_ms : {0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0}) {
    const LinkOptions link{.delay_s = 1e-3 * delay_ms};
    double rests_n_per_m = 0.0, first_swing_m = 0.0;
    for (const double k : {100.0, 150.0, 250.0, 350.0, 500.0, 750.0, 1000.0, 1500.0, 2000.0, 3000.0, 4000.0, 5500.0}) {
      const Felt at = felt(stiffer(scene, k), held(from_m, to_m, 0.1), Hold::relaxed, plant, link);
      if (at.swing_m > most_swing_m) {
        first_swing_m = at.swing_m;
        break;
      }
      rests_n_per_m = k;
    }
    const Felt hit = felt(scene, held(from_m, to_m, 0.5), Hold::relaxed, device_plant("touch"), link);
    std::printf(
        "%5.0f ms  rests up to %.0f N/m (then swings by %.2f mm)   impact at 0.5 m/s: gains %.2f mJ, steps %.2f N, swings %.3f "
        "mm\n",
        delay_ms, rests_n_per_m, 1e3 * first_swing_m, 1e3 * hit.gained_j, hit.step_n, 1e3 * hit.swing_m);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fputs("usage: bench_far_rest SCENE HAND [TIME_S [DEVICE]]\n", stderr), 2;
  try {
    measure(argc, argv);
    return 0;
  } catch (const LoadError& error) {
    std::fprintf(stderr, "bench_far_rest: %s\n", error.what());
    return 2;
  }
}
