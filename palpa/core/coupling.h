// The coupling of Eq. 1, f = k (x_proxy − x_probe) + D (v_proxy − v_probe): what it may be, and the energy that goes through
// it.
#pragma once

namespace palpa {

struct CouplingOptions {
  double stiffness_n_per_m = 500.0;  ///< k of Eq. 1; (0, 1e5]
  double damping_ns_per_m = 0.0;     ///< D of Eq. 1; [0, 100]
  double max_force_n = 3.3;          ///< length limit of what the guard lets out; (0, 100]
  double impact_ns_per_m = 0.0;      ///< pulse on hitting something hard, by the speed of the impact; [0, 100]; 0: none

  friend bool operator==(const CouplingOptions&, const CouplingOptions&) = default;
};

/// What is wrong with the options, as half a sentence; nullptr when they can be used.
const char* problem_with(const CouplingOptions& options) noexcept;

/// The energy of one tick [J].
///
/// With S = k/2 |proxy − probe|², x₀ and x_m the proxy before and after the tick, p and p⁺ the probe,
/// the spring's force held since the last tick did the work f₀·Δp on the hand, and, whatever happened
/// inside the tick,
///     f₀·Δp = S₀ − S_m + k/2 |Δp|² + I,     I = S_m − k/2 |x₀ − p⁺|²
/// As an equation of I this holds for any x; what can be wrong, and is checked by the tests, is how I
/// is split over the modes and the path. What elastic levels store, V, is of no mode: of the work of their forces only what is
/// not found again in V is. Summed over ticks, with −Δp·force as what the hand put in, it is the
/// table of a run (`palpa report`); docs/theory.md 7.7.
struct Energy {
  double stored_j = 0.0;        ///< S_m, in the spring after the tick
  double elastic_j = 0.0;       ///< V, in elastic levels after the tick
  double dissipated_j = 0.0;    ///< taken out by modes: −Σ of the modes' works below zero
  double injected_j = 0.0;      ///< brought in by modes: Σ of the modes' works above zero
  double path_j = 0.0;          ///< I − ΣW + V − V₀ − moved: the price of walking the path in sub-steps
  double damper_j = 0.0;        ///< work of the held damper force on the hand
  double moved_j = 0.0;         ///< work of the data's own motion
  double work_on_hand_j = 0.0;  ///< work of the command that was held since the last tick
  double let_go_j = 0.0;        ///< lost by the springs where the proxy went further than the hand and the data took it
  double held_back_j = 0.0;     ///< work on the hand that the guard held back: of the force less the command
  double ticks_j = 0.0;         ///< brought in by holding the force for a tick: path + k/2 |Δp|² + let go
  double ticks_bound_j = 0.0;   ///< k/2 |Δp|²: the most that one balance can have brought in so
};

}  // namespace palpa
