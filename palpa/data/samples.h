// Batch sampling of a field.
#pragma once

#include <cstdint>

#include "palpa/data/field.h"

namespace palpa::detail {

/// Samples a scalar field at places [m] of three numbers each; NaN without data. On grids, prefetches the voxels of groups of
/// places, for scattered places are bound by memory. Equal to `Field::scalar` to the bit. Allocates nothing; any thread.
/// \param values     [the field's own unit] a value for each place
/// \param gradients  [unit/m] three for each place
void sample_scalars(const Field& field, const double* places_m, std::int64_t count, double* values, double* gradients) noexcept;

}  // namespace palpa::detail
