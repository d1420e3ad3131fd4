// Closed loops: five devices in three hands, and released devices.
#include <palpa/study/released_device.h>
#include <palpa/study/spectrum.h>

#include <algorithm>
#include <span>

#include "bench/felt.h"
#include "palpa/base/printed.h"
#include "palpa/device/front.h"
#include "palpa/device/hand.h"

namespace palpa::bench {
namespace {

using detail::text;

constexpr const char* hands[] = {"let go", "relaxed", "firm"};

/// The hand's force in the tactile band once it is still.
double still_rms_n(const FeltScene& felt, const DevicePlant& plant, int hand, double beside_m) {
  constexpr double duration_s = 1.1;
  constexpr double landed_s = 1.2;  // after landing, before sliding off
  constexpr double push_n = 0.3;    // less than the strength of any level in the scenes
  double from_s = even_s;
  std::unique_ptr<SimulatedDevice> device;
  if (hand == 0) {
    from_s = landed_s;
    device = released_device(plant, felt.held.facing->at(beside_m, 0.0, -0.001), {0.0, 0.0, -push_n});
  } else {
    const auto target = hold_at(felt.held, beside_m, felt.held.depth_m, {}, from_s + duration_s);
    device = hand_device(target, hand == 1 ? Hold::relaxed : Hold::firm, plant);
  }
  const FeltRun run = feel(felt.scene, *device, from_s + duration_s);
  const FeltSignals signals = signals_of(run, from_s, from_s + duration_s);
  return spectrum_of(signals.command_n, rate_hz).band_rms(tactile_low_hz, tactile_high_hz);
}

struct Worst {
  double rms_n = 0.0;
  double share = 0.0;  ///< [1] of k · encoder step
  std::string where = "all still";
};
Worst worst_of(const FeltScene& felt, std::span<const int> of_hands, bool with_friction) {
  Worst worst;
  for (DevicePlant plant : device_plants()) {
    if (!with_friction) plant.coulomb_friction_n = 0.0;
    for (const int hand : of_hands) {
      for (const double beside : {-0.5, 0.0, 0.5}) {
        const double rms_n = still_rms_n(felt, plant, hand, beside * felt.held.radius_m);
        const double share = rms_n / (felt.scene.coupling().stiffness_n_per_m * plant.limits.encoder_step_m);
        if (share > worst.share) worst = {rms_n, share, plant.name + " " + hands[hand]};
      }
    }
  }
  return worst;
}

Figure without_friction(const FeltScene& felt, const std::string& name, std::span<const int> of_hands) {
  const Worst worst = worst_of(felt, of_hands, false);
  return {.name = name,
          .measured = text("%.2f k step (%.1f mN), ", worst.share, 1e3 * worst.rms_n) + worst.where,
          .asked = "<= 1.2 k step",
          .met = worst.share <= 1.2,
          .badness = worst.share};
}

Figure with_friction(const FeltScene& felt, const std::string& name, std::span<const int> of_hands) {
  constexpr double nothing_n = 1e-4;  // 0.1 mN counts as 0
  const Worst worst = worst_of(felt, of_hands, true);
  return {.name = name,
          .measured = text("%.2f mN, ", 1e3 * worst.rms_n) + worst.where,
          .asked = "0",
          .met = worst.rms_n <= nothing_n,
          .badness = worst.rms_n};
}

}  // namespace

std::vector<Figure> held(const FeltScene& felt) {
  constexpr int alone[] = {0}, in_hands[] = {1, 2};
  return {without_friction(felt, "held still, 5 devices, 2 hands, 20-500 Hz", in_hands),
          with_friction(felt, "held still, with Coulomb friction", in_hands),
          without_friction(felt, "let go, 5 devices, 20-500 Hz", alone),
          with_friction(felt, "let go, with Coulomb friction", alone)};
}

std::vector<Figure> released_device_figures() {
  constexpr double low = 40.0, high = 3000.0, asked_n_per_m = 500.0, least_damping_ns_per_m = 0.1;
  // [1] A stable loop of rounded positions toggles by up to three steps at single stiffnesses, far below the largest.
  constexpr double toggled_steps = 3.5;
  std::vector<Figure> figures;
  for (const char* name : {"touch", "desktop", "omega"}) {
    const std::vector<DevicePlant> plants = device_plants();
    const auto found = std::find_if(plants.begin(), plants.end(), [&](const DevicePlant& plant) { return plant.name == name; });
    std::string measured;
    double told = 0.0;
    for (const double damping_ns_per_m : {1.0, 0.5, 2.0}) {
      ReleasedDeviceOptions options{.plant = *found, .damping_ns_per_m = damping_ns_per_m, .rest_steps = toggled_steps};
      options.plant.coulomb_friction_n = 0.0;
      options.plant.damping_ns_per_m = std::max(least_damping_ns_per_m, options.plant.damping_ns_per_m);
      const auto stable = [&](double k) { return comes_to_rest(options, k); };
      const double k = largest_stable_stiffness_n_per_m(stable, low, high);
      options.uses_encoder = false;
      const double untold = largest_stable_stiffness_n_per_m(stable, low, high);
      if (damping_ns_per_m == 1.0) told = k;
      measured += text("%s%.0f at D = %g (%.0f not told)", measured.empty() ? "" : ", ", k, damping_ns_per_m, untold);
    }
    figures.push_back({.name = std::string("let go, largest stable k [N/m], ") + name,
                       .measured = measured,
                       .asked = ">= 500 at D = 1",
                       .met = told >= asked_n_per_m,
                       .badness = -told});
  }
  return figures;
}

}  // namespace palpa::bench
