// Deterministic work budget of a tick: units are counted, never timed, so that equal inputs give an equal path.
#pragma once

#include <algorithm>

namespace palpa::tick_work {

// One unit is: a piece of a straight path in an event search, a mode that places its primitives or whose data carry the proxy,
// a level estimate, a balance; and, in a balance,
inline constexpr int primitives_each = 4;        ///< [1] this number of primitives in an iteration
inline constexpr int tool_primitives_each = 16;  ///< [1] likewise of a tool, whose passes are simpler
// Pieces, modes and estimates cost more with the size of a sample:
inline constexpr int values_each = 128;  ///< [1] values per unit; a smooth grid of numbers is sampled from 64

/// [1] Work budget of a tick; no work begins after it is exhausted. More: longer worst tick; less: the proxy lags earlier.
inline constexpr int most = 4096;

/// [units] of a piece, a mode or an estimate with this number of values per sample (Field::values_per_sample): 1…`most`.
constexpr int of_sample(int values) noexcept { return std::clamp(values / values_each, 1, most); }

}  // namespace palpa::tick_work

namespace palpa {

/// Work of one tick, spent by all of its parts. The item that exhausts it is finished.
class WorkBudget {
 public:
  explicit WorkBudget(int units = 0) noexcept : all_(units), left_(units) {}
  /// Starts a tick with `times` [1] the usual work.
  void refill(int times) noexcept { left_ = all_ = times * tick_work::most; }
  void spend(int units) noexcept { left_ -= units; }
  bool any() const noexcept { return left_ > 0; }
  int left() const noexcept { return left_; }          ///< [units]; negative if the last item took more than was left
  int spent() const noexcept { return all_ - left_; }  ///< [units]

 private:
  int all_, left_;
};

}  // namespace palpa
