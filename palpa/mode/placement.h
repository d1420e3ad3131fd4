// Shared placement functions of modes.
#pragma once

#include <algorithm>
#include <cmath>

#include "palpa/mode/mode_context.h"

namespace palpa::detail {

/// Largest force along v/|v| that changes by at most k/2 per metre as it turns: (k/2)·|v|/‖∂v/∂x‖, zero where v is. Towards the
/// core of a vortex or the top of a hill, where v vanishes linearly, that is a linear fade over 2s/k.
/// \param stiffness_n_per_m  [N/m] k
/// \param length             |v|, in any unit
/// \param derivative         ∂v/∂x, that unit per hand metre
inline double steady_strength_n(double stiffness_n_per_m, double length, const Mat3& derivative) noexcept {
  const double turning =
      std::sqrt(norm_squared(derivative.row[0]) + norm_squared(derivative.row[1]) + norm_squared(derivative.row[2]));
  const double limit_n = 0.5 * stiffness_n_per_m * length / turning;
  return turning > 0.0 && std::isfinite(limit_n) ? limit_n : largest_strength_n;
}

/// Nearest point to `x_m` [m] of the level `value` [field's unit], by one Newton step along the gradient of `sample` at `x_m`;
/// at most a sample spacing away: beyond, the gradient does not locate the level.
inline Vec3 nearest_on_level_m(const ModeContext& here, const Vec3& x_m, const ScalarSample& sample, double value) noexcept {
  const double step_m = (value - sample.value) / norm(sample.gradient);
  return x_m + std::clamp(step_m, -here.finest_m, here.finest_m) * normalized(sample.gradient);
}

/// 0 up to `low`, 1 from `high` on, between them a cubic without a kink; any unit, low < high.
inline double smooth_step(double value, double low, double high) noexcept {
  const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Confidence in a gradient's direction, 0…1 [1]: 0 up to the steepness of noise, 1 from three times that on.
/// \param gradient     of a scalar field, per hand metre
/// \param noise_per_m  [unit of the field per world metre] steepness of its noise; 0: full confidence
inline double gradient_weight(const ModeContext& here, const Vec3& gradient, double noise_per_m) noexcept {
  return noise_per_m > 0.0 ? smooth_step(here.steepness_per_m(gradient), noise_per_m, 3.0 * noise_per_m) : 1.0;
}

}  // namespace palpa::detail
