// Withholds the spring extension due to unprocessed probe motion.
#pragma once

#include "palpa/solver/pose.h"

namespace palpa {

/// Applied part of the coupling's extension. The work of a tick is bounded; where data take more, a part of the probe's path
/// stays queued and lengthens the spring. From the first incomplete tick on, and until the whole extension is applied again,
/// the applied extension is
///
///     s = the point nearest to s₀ − Δp on the straight line from 0 to a (proxy − followed),
///
/// s₀ its last value, Δp the hand's step, `followed` the point of the probe's path up to which the proxy has followed it. a [1]
/// falls from 1 to 0 in 50 ms of incomplete ticks: the force fades.
///
/// An incomplete tick is passive for any motion of the proxy: |s| ≤ |s₀ − Δp|, so
/// k s₀·Δp ≤ k/2 |s₀|² − k/2 |s|² + k/2 |Δp|².
/// In a complete tick the force of proxy − probe is due: s is lengthened towards it in equal steps, complete 20 ms after the
/// last incomplete tick, or later where a step would be longer than the caller allows. A single step would be a kick. The
/// energy that a lengthening adds to k/2 |s|² is a part of the spring's energy k/2 |proxy − probe|², which the ledger has
/// booked as injected when it was withheld (docs/theory.md, 7.6).
///
/// Allocates nothing; one thread.
class LagCompensator {
 public:
  /// Returns the applied extension of this tick [m].
  /// \param extension_m    [m] proxy − probe
  /// \param to_followed_m  [m] proxy − followed
  /// \param lag_s          [s] duration of incomplete ticks; 0: this tick is complete, `to_followed_m` is `extension_m`
  /// \param left_m         [m] s₀ − Δp
  Motion applied_extension_m(const Motion& extension_m, const Motion& to_followed_m, double lag_s,
                             const Motion& left_m) noexcept;
  /// Lengthens the applied extension, after `applied_extension_m`, in a complete tick. Returns the difference [m].
  /// \param time_step_s  [s] > 0
  /// \param most_m       [m] >= 0: upper bound
  Motion give_back_m(double time_step_s, double most_m) noexcept;
  /// Withheld part [m].
  const Motion& withheld_m() const noexcept { return withheld_m_; }
  bool any() const noexcept { return any_; }
  static bool has_faded(double lag_s) noexcept { return lag_s >= fade_s; }
  /// Restarts with the proxy on the probe.
  void reset() noexcept { *this = {}; }

 private:
  // [s] Incomplete ticks until zero force. Longer: outdated forces; shorter: one busy tick is felt as a click.
  static constexpr double fade_s = 0.05;
  // [s] Return of the force, as long as its fall at a break-through. Longer: a wall is missing for longer; shorter: abrupt.
  static constexpr double give_back_s = 0.02;
  Motion withheld_m_;
  bool any_ = false;     // of it
  double left_s_ = 0.0;  // until all is returned
};

}  // namespace palpa
