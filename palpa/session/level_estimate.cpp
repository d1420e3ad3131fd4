#include "palpa/session/level_estimate.h"

#include <algorithm>

namespace palpa {

LevelEstimate estimate_level(const ScalarSample& sample, const HeldLevel& level, bool solid_is_high, const Vec3& x_m,
                             double spacing_m) noexcept {
  const double steepness = norm(sample.gradient);
  if (!sample.inside || !(steepness > 0.0)) return {x_m};
  const Vec3 uphill = normalized(sample.gradient);
  const double up = level.pressed_to - sample.value;
  const double up_m = std::clamp(up / steepness, -spacing_m, spacing_m);
  return {x_m, solid_is_high ? up_m : -up_m, x_m + up_m * uphill, solid_is_high ? -uphill : uphill, solid_is_high ? -up : up};
}

}  // namespace palpa
