#include "palpa/device/rate_hand.h"

#include <algorithm>
#include <cmath>

namespace palpa {

namespace {
constexpr double longest_pass_s = 0.1;    // larger: a pause becomes a leap; smaller: slow event loops lose motion
constexpr double longest_step_s = 50e-6;  // larger: less accurate at the stiffest coupling; smaller: only slower
}  // namespace

void RateHand::pass(const Vec3& deflection, const Vec3& force_n, double time_step_s) noexcept {
  if (!(time_step_s > 0.0)) return;
  const double reach = is_finite(deflection) ? norm(deflection) : 0.0;
  const Vec3 push_n = reach > 0.0 ? (constants_.largest_push_n * std::min(1.0, reach) / reach) * deflection : Vec3{};
  const Vec3 whole_n = push_n + (is_finite(force_n) ? force_n : Vec3{});
  const double damping_ns_per_m = constants_.largest_push_n / constants_.largest_speed_m_per_s;
  const double passed_s = std::min(time_step_s, longest_pass_s);
  const int steps = static_cast<int>(std::ceil(passed_s / longest_step_s));
  const double step_s = passed_s / steps;
  for (int i = 0; i < steps; ++i) {
    velocity_m_per_s_ =
        (constants_.mass_kg * velocity_m_per_s_ + step_s * whole_n) / (constants_.mass_kg + damping_ns_per_m * step_s);
    position_m_ += step_s * velocity_m_per_s_;
    const double far_m = norm(position_m_);
    if (far_m > constants_.radius_m) {
      const Vec3 outwards = position_m_ / far_m;
      position_m_ = constants_.radius_m * outwards;
      velocity_m_per_s_ -= std::max(0.0, dot(velocity_m_per_s_, outwards)) * outwards;
    }
  }
}

}  // namespace palpa
