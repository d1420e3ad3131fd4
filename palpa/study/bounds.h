// Closed-form bounds on the stiffness of a sampled spring.
#pragma once

#include "palpa/device/hand.h"

namespace palpa {

/// Upper bounds on a device's coupling stiffness in a loop of period T.
struct StiffnessBounds {
  /// Passive with any hand. b > k T/2 + |D| (Colgate and Schenkel 1997), with a delay τ b > k (T/2 + τ) + |D|.
  double passive_n_per_m = 0.0;
  /// Passive, with an encoder of step Δ, by Coulomb friction c and no damper: min(2 b/T, 2 c/Δ) (Abbott and Okamura 2005).
  double encoder_n_per_m = 0.0;
  /// Stable when released: k < (b + D)/(T/2 + τ) (Gil, Hulin), for a damper that is much slower than a tick.
  double stable_n_per_m = 0.0;
};
/// Bounds of a device. All are at least 0, and infinite without a bound.
/// \param damping_ns_per_m  [N·s/m] D of the coupling
/// \param period_s          [s] > 0: T
StiffnessBounds stiffness_bounds(const DevicePlant& plant, double damping_ns_per_m, double period_s) noexcept;

/// [J] Energy injected by holding the force of a wall of stiffness k for a tick, in a cycle of a hand that moves by A sin(ωt)
/// against it: (π/2) k A² sin(ω (T/2 + τ)).
/// \param amplitude_m    A
/// \param frequency_hz   ω/2π
/// \param period_s       [s] T
/// \param delay_s        [s] τ
double held_wall_energy_j(double stiffness_n_per_m, double amplitude_m, double frequency_hz, double period_s,
                          double delay_s) noexcept;

}  // namespace palpa
