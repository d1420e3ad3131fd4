// The bound that proves a balance, at 113 bits.
#pragma once

#include <span>
#include <vector>

#include "tests/solver/reference_geometry.h"

namespace palpa::test::reference {

/// A primitive's or a whole corner's share of the duality gap [N m] at x_m, the point or foot that it acts on. `u` are its
/// forces, one for each of `whole`; they are projected on the force set first. Zero for directed forces.
Quad gap_of(std::span<const Primitive> whole, const V<Quad>& x_m, Quad time_step_s, std::span<V<Quad>> u);

/// The number of primitives that act together from `i` on: the facets of a corner, else 1.
std::size_t size_of_whole(const std::vector<Primitive>& primitives, std::size_t i);

/// (ρ + √(ρ² + 4kε))/(2k) for the forces of the primitives, in their order; those of directed primitives are ignored.
Quad bound_of(const Problem& problem, const V<Quad>& x_m, std::vector<V<Quad>> forces);

}  // namespace palpa::test::reference
