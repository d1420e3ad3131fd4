// A sub-step: what it is made for, and what it says of itself.
#pragma once

#include <span>

#include "palpa/solver/law.h"

namespace palpa {

/// What a mode is told about a sub-step besides its data.
struct StepContext {
  Vec3 start_m;  ///< [m] the proxy where the sub-step begins
  Vec3 probe_m;  ///< [m]
  double time_step_s = 0.0;
  double stiffness_n_per_m = 0.0;
  double spacing_m = 0.0;      ///< [m] finest, of the data near by
  double data_fraction = 0.0;  ///< [1] of the data's motion in the sub-step, over where they are looked at
};

/// Makes what a sub-step says of itself that which its record proves: the bound, the status that goes with it, both energies.
/// For once, when all else is filled in. Allocates nothing.
/// \param placed  in this sub-step
void complete(SubStep& step, std::span<const PlacedPrimitive> placed) noexcept;

}  // namespace palpa
