// Checks of the memory and time of new grids, before allocation.
#pragma once

#include <string_view>

#include "palpa/base/limits.h"
#include "palpa/data/grid.h"

namespace palpa::detail {

/// Throws std::invalid_argument, with a sentence, if `grids` grids exceed the limit of voxels; safe from overflow.
/// \param grids  [1] >= 1
void expect_few_samples(const GridGeometry& geometry, double grids, const Limit& limit);

/// Throws likewise if they need more memory than is free, as floats.
/// \param components  [1] of each voxel, copies included
/// \param right       remedy, the end of the sentence
void expect_memory(const GridGeometry& geometry, double grids, int components, std::string_view right);

}  // namespace palpa::detail
