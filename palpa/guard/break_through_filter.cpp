#include "palpa/guard/break_through_filter.h"

#include <algorithm>

namespace palpa {

namespace {
// Fall of the force after a break-through. Faster: felt as a knock that throws the hand; slower: the break-through feels soft.
constexpr double fall_n_per_s = 500.0;
// Minimum and maximum duration of a fall. Shorter minimum: small steps are abrupt; shorter maximum: large steps (now above 10
// N) are steeper; longer maximum: force remains after the level is gone.
constexpr double shortest_s = 0.005;
constexpr double longest_s = 0.020;
constexpr double rounding_share = 1e-9;  // [1] of a step: a fall as steep as planned is not reported as a new snap
// Step beyond the hand's own that counts as a snap. Less: imperceptible steps (some 30 mN) are slowed down and reported; more:
// perceptible steps are not.
constexpr double min_snap_n = 0.05;
}  // namespace

Wrench BreakThroughFilter::shape(const Wrench& command, bool is_released, double by_hand_n, double time_step_s,
                                 bool springs_released, double turning_radius_m) noexcept {
  const Wrench rest = command - sent_;
  const double apart_n = size_n(rest, turning_radius_m);
  const double step_of_snap_n = left_s_ > time_step_s ? apart_n * time_step_s / left_s_ : apart_n;
  const bool is_under_way = left_s_ > 0.0;
  // A fall that is only as steep as planned is no new snap.
  const double known_n =
      is_under_way ? std::max(min_snap_n, (1.0 + rounding_share) * furthest_n_ * time_step_s / longest_s) : min_snap_n;
  const bool snaps = !is_released && (is_under_way ? is_snap_ : springs_released) && step_of_snap_n > by_hand_n + known_n;
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
  // Drags may hold the proxy after a release, so that a fall begins late: its time continues after it has caught up.
  left_s_ = std::max(0.0, left_s_ - time_step_s);
  sent_ = step_n >= apart_n ? command : sent_ + (step_n / apart_n) * rest;
  return sent_;
}

}  // namespace palpa
