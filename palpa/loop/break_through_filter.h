// The fall of the force where the proxy lets go.
#pragma once

#include "palpa/solver/vec3.h"

namespace palpa {

/// A level that lets go leaves a hand that pressed with newtons without any force from one tick to the next; a motor that does
/// that is heard and felt as a knock, and throws the hand. So for 20 ms what is sent goes after the command, straight towards
/// it, by 0.5 N/ms: that is the whole change of a tick, with what the spring does in the same time, as where drags hold the
/// proxy when a level has let go. What it has to go takes no less than 5 ms, so a small step is slower, and it has arrived when
/// the 20 ms are over, so a step above 10 N is faster. As much as the spring makes of the hand's own motion is never delayed: a
/// hand that draws back at once is not pushed after.
///
/// The proxy also lets go where a surface folds away below it, a strength is gone within less than the spring needs, or a
/// direction turns faster than it can follow: it snaps, further than the probe went. A step of more than 50 mN beyond the
/// hand's own, which fingers tell, then takes the whole 20 ms, so that none is left of a step of up to a newton; and so does
/// what steps while that is under way, whatever it is.
///
/// Since as much as k times the hand's way is never delayed, all that it gives to the hand is less than what the spring let go:
/// ∫ (F − k s) ds ≤ F²/2k.
///
/// What is sent lies between what was sent last and the command, so it is never longer than the longer of the two. It
/// does work on the hand like any other force: the loop books it with what the guard does to the force.
/// Allocates nothing; one thread.
class BreakThroughFilter {
 public:
  /// What is to be sent in this tick.
  /// \param command_n    [N] what would be sent without
  /// \param is_released  a level has been pressed through in this tick
  /// \param by_hand_n    [N] >= 0: k times the probe's step, and what else grows by itself
  /// \param time_step_s  [s] > 0
  /// \param has_let_go   the spring has let go of something in this tick
  Vec3 shape(const Vec3& command_n, bool is_released, double by_hand_n, double time_step_s, bool has_let_go = false) noexcept;
  /// The step [N] of a snap that was told in this tick; 0: none.
  double snap_n() const noexcept { return snap_n_; }
  /// The commands of another scene follow, which differ by so much [N] in this tick: that is no fall.
  void shift(const Vec3& step_n) noexcept { sent_n_ += step_n; }
  /// Nothing falls any more: the next command is sent as it is.
  void reset() noexcept { *this = {}; }

 private:
  Vec3 sent_n_;              // last
  double left_s_ = 0.0;      // of the 20 ms
  double furthest_n_ = 0.0;  // that it was from the command
  bool is_snap_ = false;     // no level has been pressed through
  double snap_n_ = 0.0;
};

}  // namespace palpa
