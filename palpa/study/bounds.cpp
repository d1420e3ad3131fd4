#include "palpa/study/bounds.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpa {

StiffnessBounds stiffness_bounds(const DevicePlant& plant, double damping_ns_per_m, double period_s) noexcept {
  const double b = plant.damping_ns_per_m, late_s = period_s / 2.0 + plant.delay_ticks * period_s;
  const double step_m = plant.limits.encoder_step_m;
  return {.passive_n_per_m = std::max(0.0, b - std::abs(damping_ns_per_m)) / late_s,
          .encoder_n_per_m =
              std::min(2.0 * b / period_s, step_m > 0.0 ? 2.0 * plant.coulomb_friction_n / step_m : double{INFINITY}),
          .stable_n_per_m = (b + damping_ns_per_m) / late_s};
}

double held_wall_energy_j(double stiffness_n_per_m, double amplitude_m, double frequency_hz, double period_s,
                          double delay_s) noexcept {
  const double omega = 2.0 * std::numbers::pi * frequency_hz;
  return std::numbers::pi / 2.0 * stiffness_n_per_m * amplitude_m * amplitude_m * std::sin(omega * (period_s / 2.0 + delay_s));
}

}  // namespace palpa
