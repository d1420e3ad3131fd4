#include "palpa/core/coupling.h"

#include <numbers>

namespace palpa {

namespace {
constexpr double cut_off_hz = 150.0;
constexpr double encoder_ripple_n = 0.001;  // largest force that one encoder step may make: below what a hand feels
constexpr double always_allowed_n = 0.2;
constexpr double share_of_spring = 0.5;

bool in_range(double value, double above, double at_most) noexcept { return value > above && value <= at_most; }
}  // namespace

const char* problem_with(const CouplingOptions& options) noexcept {
  if (!in_range(options.stiffness_n_per_m, 0.0, 1e5)) return "stiffness_n_per_m must be above 0 and at most 100000";
  if (!(options.damping_ns_per_m >= 0.0 && options.damping_ns_per_m <= 100.0))
    return "damping_ns_per_m must be between 0 and 100";
  if (!in_range(options.max_force_n, 0.0, 100.0)) return "max_force_n must be above 0 and at most 100";
  return nullptr;
}

Damper::Damper(double damping_ns_per_m, double encoder_step_m) noexcept
    : damping_ns_per_m_(damping_ns_per_m), cut_off_hz_(cut_off_hz) {
  const double per_hertz_n = 2.0 * std::numbers::pi * damping_ns_per_m * encoder_step_m;
  if (per_hertz_n * cut_off_hz > encoder_ripple_n) cut_off_hz_ = encoder_ripple_n / per_hertz_n;
}

Vec3 Damper::relative_velocity(const Vec3& stretch_m, const Vec3& released_m, double time_step_s,
                               double stiffness_n_per_m) noexcept {
  // In free space the filter would only decay towards zero; there the force is to be exactly zero.
  if (stretch_m == Vec3{}) {
    reset({});
    return {};
  }
  const Vec3 rate = (stretch_m - last_stretch_m_ - released_m) / time_step_s;
  last_stretch_m_ = stretch_m;
  if (time_step_s != time_step_s_) {
    time_step_s_ = time_step_s;
    weight_ = -std::expm1(-2.0 * std::numbers::pi * cut_off_hz_ * time_step_s);
  }
  filtered_m_per_s_ += weight_ * (rate - filtered_m_per_s_);
  if (!is_finite(filtered_m_per_s_)) filtered_m_per_s_ = {};
  if (damping_ns_per_m_ == 0.0) return filtered_m_per_s_;
  const double limit_n = std::max(always_allowed_n, share_of_spring * stiffness_n_per_m * norm(stretch_m));
  return shortened(filtered_m_per_s_, limit_n / damping_ns_per_m_);
}

void Damper::reset(const Vec3& stretch_m) noexcept {
  last_stretch_m_ = stretch_m;
  filtered_m_per_s_ = {};
}

}  // namespace palpa
