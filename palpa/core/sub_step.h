// What a sub-step says of itself.
#pragma once

#include <span>

#include "palpa/core/law.h"

namespace palpa {

/// Makes what a sub-step says of itself that which its record proves: the bound, the status that goes with it, both energies.
/// For once, when all else is filled in. Allocates nothing.
/// \param placed  in this sub-step
void complete(SubStep& step, std::span<const PlacedPrimitive> placed) noexcept;

}  // namespace palpa
