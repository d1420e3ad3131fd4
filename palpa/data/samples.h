// Many samples of a field at once.
#pragma once

#include <cstdint>

#include "palpa/data/field.h"

namespace palpa::detail {

/// Samples a scalar field at places [m] of which three numbers each are given; NaN where it has no data. On grids places are
/// taken in groups, whose voxels are fetched from memory together: what is far apart costs its time there. Bit by bit the
/// values of `Field::scalar`. Allocates nothing; any thread.
/// \param values     [the field's own unit] one for each place
/// \param gradients  [unit/m] three for each place
void sample_scalars(const Field& field, const double* places_m, std::int64_t count, double* values, double* gradients) noexcept;

}  // namespace palpa::detail
