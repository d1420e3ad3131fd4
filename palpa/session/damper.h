// The damper of the coupling (Eq. 1).
#pragma once

#include <array>

#include "palpa/solver/vec3.h"

namespace palpa {

/// The damper of Eq. 1. It acts on the rate of change of x_proxy − x_probe, estimated as one, so that in
/// free space, where the two are the same point, it is exactly zero: two differently filtered velocities
/// would leave a force there. What the proxy covers in a release (break-through, event) is no motion of
/// the hand and is left out; and the damper never exceeds the larger of 0.2 N and half the spring's force,
/// so that no kick can come from it.
///
/// Without an encoder step the estimate is the difference of two ticks behind a first-order low-pass of
/// 150 Hz. With one, a low-pass that quietens a step is so slow that nothing is damped any more. There the
/// estimate is, component by component, the slope of the longest straight line from the past to now that
/// no position in between is further from than positions rounded to the step can be from a steady motion
/// (first-order adaptive windowing: Janabi-Sharifi, Hayward and Chen, IEEE Trans. Control Syst. Technol. 8(6),
/// 2000). A fast change is seen over 3 ms, as late as that low-pass, a slow motion over up to W = 3D/k,
/// at most 24 ms. Such a motion ripples by q/W in the estimate, so by k q/3 in the force, where the spring itself
/// ripples by k q. It costs a delay of W/2 at most (docs/theory.md, 7.8).
class Damper {
 public:
  /// \param damping_ns_per_m  [N·s/m] D, >= 0
  /// \param encoder_step_m    [m] position step q of the device, 0 if none
  explicit Damper(double damping_ns_per_m, double encoder_step_m = 0.0) noexcept;

  /// v_proxy − v_probe [m/s] as the damper sees it, limited as above; D times it is the damper's force.
  /// \param stretch_m    [m] proxy − probe now
  /// \param released_m   [m] the part of the proxy's motion in this tick that was a release
  /// \param time_step_s  [s] > 0
  Vec3 relative_velocity(const Vec3& stretch_m, const Vec3& released_m, double time_step_s, double stiffness_n_per_m) noexcept;

  /// Starts anew from `stretch_m`, as if it had been so for long: after a gap, a clutch, a new map.
  void reset(const Vec3& stretch_m) noexcept;

 private:
  // [1] Past positions in a window. More: slower; fewer: their spacing, window/(most_kept − 1), is coarser.
  static constexpr int most_kept = 32;

  Vec3 smoothed(const Vec3& stretch_m, const Vec3& released_m, double time_step_s) noexcept;
  Vec3 windowed(const Vec3& stretch_m, const Vec3& released_m, double time_step_s, double stiffness_n_per_m) noexcept;

  double damping_ns_per_m_;
  double encoder_step_m_;
  double time_step_s_ = 0.0;  // of the last tick
  double weight_ = 0.0;       // [1] share of a new rate that the filter takes over in that time
  Vec3 last_stretch_m_;
  Vec3 filtered_m_per_s_;

  // A past position in the window. Before the first one kept the stretch counts as constant.
  struct Kept {
    double time_s = 0.0;
    Vec3 stretch_m;
  };
  double time_s_ = 0.0;  // since the reset
  int newest_ = 0;
  int kept_ = 1;
  std::array<Kept, most_kept> past_;
};

/// The part of the proxy's step [m] beyond how far probe and data moved [m]: a release, which the damper leaves out.
Vec3 released_part(const Vec3& step_m, double moved_m) noexcept;

}  // namespace palpa
