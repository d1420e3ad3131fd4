// Coupling of Eq. 1, f = k (x_proxy − x_probe) + D (v_proxy − v_probe): options and energy.
#pragma once

#include <optional>

namespace palpa {

/// Spring and damper between proxy and hand.
struct CouplingOptions {
  double stiffness_n_per_m = 500.0;  ///< k of Eq. 1; (0, 1e5]
  double damping_ns_per_m = 0.0;     ///< D of Eq. 1; [0, 100]
  double max_force_n = 3.3;          ///< force limit of the guard; (0, 100]
  double impact_ns_per_m = 0.0;      ///< contact transient: force per speed of the impact on a hard level; [0, 100]
  double max_torque_nm = 0.3;        ///< torque limit of the guard, for a tool; (0, 10]
  /// Torque per angular velocity of proxy − probe, for a tool; [0, 1]. None: D times its turning radius squared.
  std::optional<double> turn_damping_nms_per_rad{};

  friend bool operator==(const CouplingOptions&, const CouplingOptions&) = default;
};

/// First fault of the options, as half a sentence; nullptr if valid. Allocates nothing; any thread.
const char* problem_with(const CouplingOptions& options) noexcept;

/// Energy of one tick [J].
///
/// With S = k/2 |proxy − probe|², x₀ and x_m the proxy before and after the tick, p and p⁺ the probe, the spring's force held
/// since the last tick did the work f₀·Δp on the hand, and, for any path of the proxy,
///     f₀·Δp = S₀ − S_m + k/2 |Δp|² + I,     I = S_m − k/2 |x₀ − p⁺|²
/// As an equation of I this holds for any x; the tests check the split of I over the modes and the path. The energy V stored in
/// elastic levels belongs to no mode: a mode is charged with the work of their forces less the change of V. Summed over ticks,
/// with −Δp·force as the hand's input, this is the table of a run (`palpa report`); docs/theory.md 7.7.
struct Energy {
  double stored_j = 0.0;            ///< S_m, in the spring after the tick
  double elastic_j = 0.0;           ///< V, in elastic levels after the tick
  double dissipated_j = 0.0;        ///< by modes: −Σ of the modes' works below zero
  double injected_j = 0.0;          ///< by modes: Σ of the modes' works above zero
  double path_and_release_j = 0.0;  ///< I − ΣW + V − V₀ − moved: error of the path's sub-steps (ΣW: works of modes)
  double damper_j = 0.0;            ///< work on the hand of the held force less k (proxy − probe): damper, withheld extension
  double data_motion_j = 0.0;       ///< work of the data's motion
  double released_j = 0.0;          ///< released by the springs: the proxy moved further than hand and data
  double sampling_j = 0.0;          ///< sampling error (zero-order hold): path + k/2 |Δp|² + let go
  double sampling_bound_j = 0.0;    ///< k/2 |Δp|²: upper bound of the sampling error of a single balance
};

}  // namespace palpa
