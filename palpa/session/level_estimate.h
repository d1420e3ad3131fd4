// A level as one sample of its field sees it.
#pragma once

#include "palpa/mode/mode_context.h"

namespace palpa {

/// A level as one Newton step from a place sees it.
struct LevelEstimate {
  Vec3 at_m;                       ///< the place; that and the rest in the hand frame
  double signed_distance_m = 0.0;  ///< how far in front of the level it is; without data, or a gradient, it counts as on it
  Vec3 foot_m, normal;             ///< the nearest place on it, and its direction out of the solid [1]
  double behind = 0.0;  ///< by how much the value there is beyond the level's, in the field's own unit, > 0 in the solid
};

/// Looks at `level` from `x_m` [hand m]; `solid_is_high`: higher values are the solid. No level is further away than
/// `spacing_m` [m] for it: beyond, the gradient says nothing. Samples; allocates nothing.
LevelEstimate estimate_level(Samples& samples, const HeldLevel& level, bool solid_is_high, const Vec3& x_m,
                             double spacing_m) noexcept;

}  // namespace palpa
