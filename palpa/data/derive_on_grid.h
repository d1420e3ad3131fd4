// Fields computed once, at the nodes of a grid, from another field: the work behind `derived`.
#pragma once

#include "palpa/data/derived.h"
#include "palpa/data/grid.h"

namespace palpa::detail {

/// Curl, divergence, gradient magnitude, Q, lambda2 of the field or the field smoothed, times `factor` [1], at the
/// nodes of `geometry`, as a field sampled by the smoothing cubic. Where `of` is an affine grid, `geometry` must
/// be its own, and its voxels are read as they are. `smoothing_m` [m] as for `derived`, which says how.
FieldPtr derive_on_grid(Derivation derivation, const Field& of, const GridGeometry& geometry, double smoothing_m,
                        double factor);

}  // namespace palpa::detail
