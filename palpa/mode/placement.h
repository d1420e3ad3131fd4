// What several modes need to place a primitive.
#pragma once

#include <algorithm>
#include <cmath>

#include "palpa/mode/here.h"

namespace palpa::detail {

/// The most newtons that a force along v/|v| may have so that turning alone changes it by at most k/2 per
/// metre: (k/2)·|v|/‖∂v/∂x‖, zero where v is. Towards the core of a vortex or the top of a hill, where v
/// vanishes linearly, that is a linear fade over 2s/k.
/// \param stiffness_n_per_m  [N/m] k
/// \param length             |v|, in any unit
/// \param derivative         ∂v/∂x, that unit per hand metre
inline double steady_strength_n(double stiffness_n_per_m, double length, const Mat3& derivative) noexcept {
  const double turning =
      std::sqrt(norm_squared(derivative.row[0]) + norm_squared(derivative.row[1]) + norm_squared(derivative.row[2]));
  const double limit_n = 0.5 * stiffness_n_per_m * length / turning;
  return turning > 0.0 && std::isfinite(limit_n) ? limit_n : largest_strength_n;
}

/// The point next to the proxy where the field has `value` [field's unit], by one Newton step along the gradient; never
/// further than a sample spacing: beyond, the gradient says nothing about where the level is.
inline Vec3 foot_on_level_m(const Here& here, const ScalarSample& sample, double value) noexcept {
  const double step_m = (value - sample.value) / norm(sample.gradient);
  return here.at_m + std::clamp(step_m, -here.finest_m, here.finest_m) * normalized(sample.gradient);
}

}  // namespace palpa::detail
