#include "palpa/guard/impact.h"

#include <algorithm>
#include <cmath>

namespace palpa {

namespace {

// Decay of the pulse, as of a knock on wood. Longer: more impulse per gain, so that hands of more mass could gain energy from
// it; shorter: less of a knock.
constexpr double decay_s = 0.004;
// End of the pulse. Shorter: cut off before it has decayed (to a hundredth); longer: imperceptible rest.
constexpr double whole_s = 0.020;
// Averaging time of an impact's speed. Shorter: noisier (a step of 55 um is 7 mm/s); longer: late when the hand speeds up
// before the impact.
constexpr double velocity_s = 0.008;

// Relative height of the pulse with `left_s` remaining [1].
double share_at(double left_s) noexcept {
  const double end = std::exp(-whole_s / decay_s);
  return (std::exp((left_s - whole_s) / decay_s) - end) / (1.0 - end);
}

}  // namespace

void Impact::move(const Vec3& probe_step_m, const Vec3& probe_turn_rad, double time_step_s) noexcept {
  newest_ = (newest_ + 1) % steps_.size();
  steps_[newest_] = {probe_step_m, probe_turn_rad, time_step_s};
  left_s_ = std::max(0.0, left_s_ - time_step_s);
}

void Impact::hit(const HardContact& level) noexcept {
  const double speed_m_per_s = std::max(0.0, -dot(level.normal, velocity_m_per_s(level.lever_m)));
  const double height_n = std::min(gain_ns_per_m_ * speed_m_per_s, level.strength_n);
  const double now_n = left_s_ > 0.0 ? share_at(left_s_) * norm(height_.force_n) : 0.0;
  if (!(height_n > now_n)) return;
  height_ = {height_n * level.normal, cross(level.lever_m, height_n * level.normal)};
  left_s_ = whole_s;
}

Wrench Impact::shape(const Wrench& command) const noexcept {
  return left_s_ > 0.0 && gain_ns_per_m_ > 0.0 ? command + share_at(left_s_) * height_ : command;
}

// Of the foot with this lever. Mean over the last ticks: two positions of an encoder alone are too coarse.
Vec3 Impact::velocity_m_per_s(const Vec3& lever_m) const noexcept {
  Vec3 way_m, turn_rad;
  double time_s = 0.0;
  for (std::size_t i = 0; i < steps_.size() && time_s < velocity_s; ++i) {
    const Step& step = steps_[(newest_ + steps_.size() - i) % steps_.size()];
    way_m += step.way_m;
    turn_rad += step.turn_rad;
    time_s += step.time_s;
  }
  return time_s > 0.0 ? (way_m + cross(turn_rad, lever_m)) / time_s : Vec3{};
}

}  // namespace palpa
