// Context of a sub-step, and its proven quantities.
#pragma once

#include <span>

#include "palpa/solver/law.h"

namespace palpa {

/// Arguments of a sub-step besides its data.
struct StepContext {
  Vec3 start_m;  ///< [m] proxy at its start
  Vec3 probe_m;  ///< [m]
  double time_step_s = 0.0;
  double stiffness_n_per_m = 0.0;
  double spacing_m = 0.0;  ///< [m] finest, of the data nearby
};

/// Computes bound, status and energies from the recorded primitives; call once, last. Allocates nothing.
void complete(SubStep& step, std::span<const PlacedPrimitive> placed) noexcept;

}  // namespace palpa
