// First-order level estimate from one sample.
#pragma once

#include "palpa/mode/mode_context.h"

namespace palpa {

/// First-order estimate of a level: one Newton step from a position.
struct LevelEstimate {
  Vec3 at_m;                       ///< sampled position; like the other vectors in the hand frame
  double signed_distance_m = 0.0;  ///< > 0 in front of the level; without data, or a gradient, 0
  Vec3 nearest_m, normal;          ///< nearest point on it, and its direction out of the solid [1]
  double behind = 0.0;             ///< difference from the level's value, in the field's own unit, > 0 in the solid
};

/// Estimates `level` from a sample of its field at `x_m` [hand m]; `solid_is_high`: higher values are the solid. Distances are
/// at most `spacing_m` [m]: the gradient is no guide beyond. Allocates nothing.
LevelEstimate estimate_level(const ScalarSample& sample, const HeldLevel& level, bool solid_is_high, const Vec3& x_m,
                             double spacing_m) noexcept;

}  // namespace palpa
