// Context of a sub-step, and its proven quantities.
#pragma once

#include <span>

#include "palpa/solver/law.h"

namespace palpa {

/// Arguments of a sub-step besides its data.
struct StepContext {
  Pose start;  ///< [m] proxy at its start
  Pose probe;  ///< [m]
  double time_step_s = 0.0;
  double stiffness_n_per_m = 0.0;
  double spacing_m = 0.0;  ///< [m] finest, of the data nearby
};

/// Computes bound, status and energies from the recorded primitives; call once, last. Allocates nothing.
void complete(SubStep& step, std::span<const PlacedPrimitive> placed) noexcept;

}  // namespace palpa
