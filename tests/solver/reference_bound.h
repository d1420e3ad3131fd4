// The bound that proves a balance, at 113 bits.
#pragma once

#include <vector>

#include "tests/solver/reference_geometry.h"

namespace palpa::test::reference {

/// (ρ + √(ρ² + 4kε))/(2k) for the forces of the primitives, in their order; those of directed primitives are ignored.
Quad bound_of(const Problem& problem, const V<Quad>& x_m, std::vector<V<Quad>> forces);

}  // namespace palpa::test::reference
