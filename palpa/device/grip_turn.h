// Orientation of a grip between its readings.
#pragma once

#include <algorithm>

#include "palpa/solver/pose.h"

namespace palpa {

/// Orientation of a grip that reports at a lower rate than the loop's, 50 Hz as a rule: each new reading is approached over one
/// period at constant angular velocity (slerp). Without that the tip of a tool would jerk by its lever times the step of the
/// reading. Late by one period. Its time comes from its input; allocates nothing; one thread.
class GripTurn {
 public:
  /// Orientation at a time.
  /// \param time_s   [s] never decreasing
  /// \param reading  of unit length: the grip's latest, new or repeated
  Turn at(double time_s, const Turn& reading) noexcept {
    if (!has_reading_) {
      from_ = to_ = reading_ = reading;
      has_reading_ = true;
      read_s_ = time_s;
    } else if (reading != reading_) {
      const double passed_s = time_s - read_s_;
      if (passed_s < longest_period_s) period_s_ += newest_share * (passed_s - period_s_);
      from_ = walked(time_s);
      reading_ = reading;
      // Of the two quaternions of a rotation the nearer.
      const bool is_far = from_.w * reading.w + from_.x * reading.x + from_.y * reading.y + from_.z * reading.z < 0.0;
      to_ = is_far ? Turn{-reading.w, -reading.x, -reading.y, -reading.z} : reading;
      read_s_ = time_s;
    }
    return walked(time_s);
  }
  /// After a gap: the next reading is taken at once.
  void reset() noexcept { *this = {}; }

 private:
  // Longer intervals are those of a grip at rest, whose readings are equal. Longer: after a rest the first turn is slow;
  // shorter: grips below 10 Hz jerk.
  static constexpr double longest_period_s = 0.1;
  // Weight [1] of the newest interval in the mean. More: jitter of the messages is felt; less: late after a change of rate.
  static constexpr double newest_share = 0.2;

  Turn walked(double time_s) const noexcept {
    const double share = std::clamp((time_s - read_s_) / period_s_, 0.0, 1.0);
    return share >= 1.0 ? to_ : turned_further(from_, share * rotation_between_rad(from_, to_));
  }

  bool has_reading_ = false;
  Turn from_, to_, reading_;
  double read_s_ = 0.0;
  double period_s_ = 0.02;  // of 50 Hz, until it is known
};

}  // namespace palpa
