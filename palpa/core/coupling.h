// The coupling of Eq. 1: f = k (x_proxy − x_probe) + D (v_proxy − v_probe).
#pragma once

#include "palpa/core/vec3.h"

namespace palpa {

struct CouplingOptions {
  double stiffness_n_per_m = 500.0;  ///< k of Eq. 1; (0, 1e5]
  double damping_ns_per_m = 0.0;     ///< D of Eq. 1; [0, 100]
  double max_force_n = 3.3;          ///< length limit of what the guard lets out; (0, 100]

  friend bool operator==(const CouplingOptions&, const CouplingOptions&) = default;
};

/// What is wrong with the options, as half a sentence; nullptr when they can be used.
const char* problem_with(const CouplingOptions& options) noexcept;

/// The damper of Eq. 1. It acts on the rate of change of x_proxy − x_probe, through one first-order
/// low-pass, so that in free space, where the two are the same point, it is exactly zero: two
/// differently filtered velocities would leave a force there. What the proxy covers in a release
/// (break-through, event) is no motion of the hand and is left out; and the damper never exceeds the
/// larger of 0.2 N and half the spring's force, so that no kick can come from it.
class Damper {
 public:
  /// \param damping_ns_per_m  [N·s/m] D, >= 0
  /// \param encoder_step_m    [m] position step of the device, 0 if none: the cut-off (150 Hz) is
  ///                          lowered until one step makes no more than 1 mN
  explicit Damper(double damping_ns_per_m, double encoder_step_m = 0.0) noexcept;

  /// v_proxy − v_probe [m/s] as the damper sees it, limited as above; D times it is the damper's force.
  /// \param stretch_m    [m] proxy − probe now
  /// \param released_m   [m] the part of the proxy's motion in this tick that was a release
  /// \param time_step_s  [s] > 0
  Vec3 relative_velocity(const Vec3& stretch_m, const Vec3& released_m, double time_step_s, double stiffness_n_per_m) noexcept;

  /// Starts anew from `stretch_m`: after a gap, a clutch, a new map.
  void reset(const Vec3& stretch_m) noexcept;

 private:
  double damping_ns_per_m_;
  double cut_off_hz_;
  double time_step_s_ = 0.0;  // of the last tick …
  double weight_ = 0.0;       // … and what the filter takes of what is new in so long
  Vec3 last_stretch_m_;
  Vec3 filtered_m_per_s_;
};

}  // namespace palpa
