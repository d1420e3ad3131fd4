// Forces on the feet of a tool.
#pragma once

#include <algorithm>
#include <span>

#include "palpa/solver/law.h"

namespace palpa {

/// Adds the force of each primitive on the proxy to that of its foot. Feet beyond the end of `forces_n` are left out. Allocates
/// nothing; any thread.
/// \param placed    of one sub-step
/// \param forces_n  [N] by the number of the foot
inline void add_foot_forces(std::span<const PlacedPrimitive> placed, std::span<Vec3> forces_n) noexcept {
  for (const PlacedPrimitive& one : placed)
    if (one.primitive.id.foot < forces_n.size()) forces_n[one.primitive.id.foot] += one.force_n;
}

/// [N] Least force drawn as the largest. Less: rounding is red; more: a light touch is not seen.
inline constexpr double least_red_n = 0.05;

/// Share [1] of red in the colour of a foot: 0 without force, 1 at the largest. A foot that bears a little differs visibly from
/// one that bears nothing. Allocates nothing; any thread.
/// \param force_n  [N] on the foot
/// \param most_n   [N] largest on any foot
inline double redness(double force_n, double most_n) noexcept {
  constexpr double contact_n = 1e-3, first = 0.35;
  return force_n > contact_n ? first + (1.0 - first) * std::min(1.0, force_n / std::max(most_n, least_red_n)) : 0.0;
}

}  // namespace palpa
