// What a tick may do: units of work, which are counted and never timed, so that the same inputs give the same path.
#pragma once

#include <algorithm>

namespace palpa::tick_work {

// A unit is: a piece of a straight way that is searched for events, a mode that places its primitives or whose data carry the
// proxy, a look at a level, a balance; and, of a balance,
inline constexpr int primitives_each = 4;  ///< [1] so many primitives in one of its iterations
// Pieces, modes and looks are more where a sample of their data is:
inline constexpr int values_each = 128;  ///< [1] so many values are a unit; a smooth grid of numbers is sampled by 64

/// [1] A tick begins nothing once it has spent this. More: longer worst tick; less: the proxy lags behind the hand sooner.
inline constexpr int most = 4096;

/// [units] of a piece, a mode or a look whose sample is made of so many values (Field::values_per_sample): 1…`most`.
constexpr int of_sample(int values) noexcept { return std::clamp(values / values_each, 1, most); }

}  // namespace palpa::tick_work

namespace palpa {

/// Work of one tick: refilled at its start, spent by all that the tick does. What takes the last of it is finished.
class WorkBudget {
 public:
  explicit WorkBudget(int units = 0) noexcept : all_(units), left_(units) {}
  /// Starts a tick with `times` [1] the usual work.
  void refill(int times) noexcept { left_ = all_ = times * tick_work::most; }
  void spend(int units) noexcept { left_ -= units; }
  bool any() const noexcept { return left_ > 0; }
  int left() const noexcept { return left_; }  ///< [units]; negative where the last piece of work took more than was left
  int spent() const noexcept { return all_ - left_; }  ///< [units]

 private:
  int all_, left_;
};

}  // namespace palpa
