// How the force falls when a level has been pressed through.
#pragma once

#include "palpa/core/vec3.h"

namespace palpa {

/// A level that lets go leaves a hand that pressed with newtons without any force from one tick to the next; a motor that does
/// that is heard and felt as a knock, and throws the hand. So what the hand has had beyond the force that is left falls in a
/// straight line to zero, by 0.5 N/ms, but in no less than 5 ms and no more than 20 ms. It is a force in the direction of the
/// old one and does work on the hand like any other: the loop books it with what the guard does to the force.
/// Allocates nothing; one thread.
class Release {
 public:
  /// What is to be sent in this tick.
  /// \param command_n    [N] what would be sent without
  /// \param is_released  a level has been pressed through in this tick
  /// \param time_step_s  [s] > 0
  Vec3 shape(const Vec3& command_n, bool is_released, double time_step_s) noexcept;
  /// Nothing falls any more: the next command is sent as it is.
  void reset() noexcept { *this = {}; }

 private:
  Vec3 sent_n_;     // last
  Vec3 falling_n_;  // what fell when it began
  double left_s_ = 0.0, whole_s_ = 0.0;
};

}  // namespace palpa
