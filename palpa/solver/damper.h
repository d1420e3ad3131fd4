// Damper of the coupling (Eq. 1).
#pragma once

#include <array>

#include "palpa/solver/pose.h"

namespace palpa {

/// Damper of Eq. 1, on the rate of change of x_proxy − x_probe. Estimated as one quantity, it is exactly zero in free space,
/// where the two points coincide: two differently filtered velocities would leave a force there. Proxy motion in a release
/// (break-through, event) is no motion of the hand and is left out; and the damper never exceeds the larger of 0.2 N and half
/// the spring's force, so that it cannot cause a kick.
///
/// Without an encoder step the estimate is the difference of two ticks behind a first-order low-pass of 150 Hz. A low-pass that
/// quietens an encoder step is too slow to damp anything. The estimate is then, by component, the slope of the longest straight
/// line from the past to now from which no position in between deviates by more than a steady motion rounded to the step can
/// (first-order adaptive windowing: Janabi-Sharifi, Hayward and Chen, IEEE Trans. Control Syst. Technol. 8(6), 2000). The
/// window is 3 ms for a fast change, with the delay of that low-pass, and up to W = 3D/k, at most 24 ms, for a slow motion,
/// which ripples by q/W in the estimate, so by k q/3 in the force; the spring itself ripples by k q. The delay is W/2 at most
/// (docs/theory.md, 7.8).
class Damper {
 public:
  /// \param damping_ns_per_m  [N·s/m] D, >= 0
  /// \param encoder_step_m    [m] position step q of the device, 0 if none
  /// \param turns             false: all arcs are zero
  explicit Damper(double damping_ns_per_m, double encoder_step_m = 0.0, bool turns = true) noexcept;

  /// Estimate of the velocity of proxy − probe [m/s], limited as above; the force is D times it, and the torque of a tool D ρ
  /// times its arc.
  /// \param stretch_m    [m] from probe to proxy now
  /// \param released_m   [m] part of the proxy's motion in this tick that was a release
  /// \param time_step_s  [s] > 0
  Motion relative_velocity(const Motion& stretch_m, const Motion& released_m, double time_step_s,
                           double stiffness_n_per_m) noexcept;

  /// Restarts with a constant past extension `stretch_m` [m]: after a gap, a clutch, a new map.
  void reset(const Motion& stretch_m) noexcept;

 private:
  // [1] Past positions in a window. More: slower; fewer: their spacing, window/(most_kept − 1), is coarser.
  static constexpr int most_kept = 32;

  double length_m(const Motion& motion) const noexcept { return turns_ ? length(motion) : norm(motion.way_m); }
  Motion smoothed(const Motion& stretch_m, const Motion& released_m, double time_step_s) noexcept;
  Motion windowed(const Motion& stretch_m, const Motion& released_m, double time_step_s, double stiffness_n_per_m) noexcept;

  double damping_ns_per_m_;
  double encoder_step_m_;
  bool turns_;
  double time_step_s_ = 0.0;  // of the last tick
  double weight_ = 0.0;       // [1] of a new rate in the filter, in that time
  Motion last_stretch_m_;
  Motion filtered_m_per_s_;

  // Past position in the window. Earlier, the extension counts as constant.
  struct Kept {
    double time_s = 0.0;
    Motion stretch_m;
  };
  double time_s_ = 0.0;  // since the reset
  int newest_ = 0;
  int kept_ = 1;
  std::array<Kept, most_kept> past_;
};

}  // namespace palpa
