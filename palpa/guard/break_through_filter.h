// Limited fall of the force at a release.
#pragma once

#include "palpa/guard/wrench.h"

namespace palpa {

/// A released level would take newtons of force from a pressing hand within one tick: heard and felt as a knock, which throws
/// the hand. So for 20 ms the output follows the command, straight towards it, by 0.5 N/ms: that is the whole change of a tick,
/// with the spring's own change in that time, as where drags hold the proxy after a release. The fall takes at least 5 ms, so a
/// small step is slower, and it ends with the 20 ms, so a step above 10 N is faster. The change due to the hand's own motion is
/// never delayed: a hand that draws back at once is not pushed after.
///
/// The proxy is also released where a surface folds away below it, a strength vanishes within less than the spring needs, or a
/// direction turns faster than it can follow: it snaps, further than the probe moved. A step of more than 50 mN beyond the
/// hand's own, which is perceptible, then takes the whole 20 ms, so that no step remains of up to a newton; and so does any
/// step during that time.
///
/// Since k times the hand's motion is never delayed, the hand gains less energy than the spring released: ∫ (F − k s) ds ≤
/// F²/2k.
///
/// Force and torque fall together, on one straight line; a torque counts as a force at the turning radius of the tool.
///
/// The output lies between the last output and the command, so it is never longer than the longer of the two. The loop books
/// its work on the hand with that of the guard. Allocates nothing; one thread.
class BreakThroughFilter {
 public:
  /// Output of this tick.
  /// \param command           unfiltered command
  /// \param is_released       break-through of a level in this tick
  /// \param by_hand_n         [N] >= 0: k times the probe's step, and any other gradual change
  /// \param time_step_s       [s] > 0
  /// \param springs_released  the spring has released energy in this tick
  /// \param turning_radius_m  [m] > 0: of the tool
  Wrench shape(const Wrench& command, bool is_released, double by_hand_n, double time_step_s, bool springs_released,
               double turning_radius_m) noexcept;
  /// Step [N] of a snap reported in this tick; 0: none.
  double snap_n() const noexcept { return snap_n_; }
  /// Shifts the output by the step between two scenes' commands, which is no fall.
  void shift(const Wrench& step) noexcept { sent_ = sent_ + step; }
  /// Ends any fall: the next command is passed unchanged.
  void reset() noexcept { *this = {}; }

 private:
  Wrench sent_;              // last output
  double left_s_ = 0.0;      // of the 20 ms
  double furthest_n_ = 0.0;  // largest distance from the command
  bool is_snap_ = false;     // not by a break-through
  double snap_n_ = 0.0;
};

}  // namespace palpa
