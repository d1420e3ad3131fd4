// How the force falls when a level has been pressed through.
#pragma once

#include "palpa/core/vec3.h"

namespace palpa {

/// A level that lets go leaves a hand that pressed with newtons without any force from one tick to the next; a motor that does
/// that is heard and felt as a knock, and throws the hand. So for 20 ms what is sent goes after the command, straight towards
/// it, by 0.5 N/ms: that is the whole change of a tick, with what the spring does in the same time, as where drags hold the
/// proxy when a level has let go. What it has to go takes no less than 5 ms, so a small step is slower, and it has arrived when
/// the 20 ms are over, so a step above 10 N is faster. As much as the spring makes of the hand's own motion is never delayed: a
/// hand that draws back at once is not pushed after.
///
/// What is sent lies between what was sent last and the command, so it is never longer than the longer of the two. It
/// does work on the hand like any other force: the loop books it with what the guard does to the force.
/// Allocates nothing; one thread.
class Release {
 public:
  /// What is to be sent in this tick.
  /// \param command_n    [N] what would be sent without
  /// \param is_released  a level has been pressed through in this tick
  /// \param by_hand_n    [N] >= 0: k times the probe's step
  /// \param time_step_s  [s] > 0
  Vec3 shape(const Vec3& command_n, bool is_released, double by_hand_n, double time_step_s) noexcept;
  /// Nothing falls any more: the next command is sent as it is.
  void reset() noexcept { *this = {}; }

 private:
  Vec3 sent_n_;              // last
  double left_s_ = 0.0;      // of the 20 ms
  double furthest_n_ = 0.0;  // that it was from the command
};

}  // namespace palpa
