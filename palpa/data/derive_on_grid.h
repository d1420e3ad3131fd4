// Derived fields computed once at the nodes of a grid, for `derived`.
#pragma once

#include "palpa/data/derived.h"
#include "palpa/data/grid.h"

namespace palpa::detail {

/// Curl, divergence, gradient magnitude, Q, lambda2 of the field or the smoothed field, times `factor` [1], at the nodes of
/// `geometry`, as a field sampled by the smoothing cubic. If `of` is an affine grid, `geometry` must be its own; its voxels are
/// read directly. `smoothing_m` [m] as for `derived`, with its method.
FieldPtr derive_on_grid(Derivation derivation, const Field& of, const GridGeometry& geometry, double smoothing_m,
                        double factor);

}  // namespace palpa::detail
