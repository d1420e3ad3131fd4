#include <algorithm>

#include "palpa/loop/loop.h"

namespace palpa {

namespace {
constexpr double fall_n_per_s = 500.0;  // slower than a knock, faster than anyone would call soft
constexpr double shortest_s = 0.005;
constexpr double longest_s = 0.020;
constexpr double rounding_share = 1e-9;
constexpr double told_n = 0.05;  // fingers tell steps of some 30 mN
}  // namespace

Vec3 Release::shape(const Vec3& command_n, bool is_released, double by_hand_n, double time_step_s, bool has_let_go) noexcept {
  const Vec3 rest_n = command_n - sent_n_;
  const double apart_n = norm(rest_n);
  const double step_of_snap_n = left_s_ > time_step_s ? apart_n * time_step_s / left_s_ : apart_n;
  const bool is_under_way = left_s_ > 0.0;
  // What is as fast as it was to be has been told.
  const double known_n =
      is_under_way ? std::max(told_n, (1.0 + rounding_share) * furthest_n_ * time_step_s / longest_s) : told_n;
  const bool snaps = !is_released && (is_under_way ? is_snap_ : has_let_go) && step_of_snap_n > by_hand_n + known_n;
  snap_n_ = snaps ? apart_n : 0.0;
  if (is_released || snaps) {
    left_s_ = longest_s;
    furthest_n_ = 0.0;
    is_snap_ = snaps;
  }
  furthest_n_ = std::max(furthest_n_, apart_n);
  double step_n = apart_n;
  if (left_s_ > time_step_s) {
    const double steady_n = is_snap_ ? 0.0 : std::min(furthest_n_ / shortest_s, fall_n_per_s) * time_step_s;
    step_n = std::max({steady_n, apart_n * time_step_s / left_s_, by_hand_n});
  }
  // Drags may hold the proxy when the level has let go, so that a fall begins late: its time is not over when it has caught up.
  left_s_ = std::max(0.0, left_s_ - time_step_s);
  sent_n_ = step_n >= apart_n ? command_n : sent_n_ + (step_n / apart_n) * rest_n;
  return sent_n_;
}

}  // namespace palpa
