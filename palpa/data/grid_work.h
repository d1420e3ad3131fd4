// What grids cost that are made here, looked at before any of it is taken.
#pragma once

#include <string_view>

#include "palpa/base/limits.h"
#include "palpa/data/grid.h"

namespace palpa::detail {

/// Throws std::invalid_argument, with a sentence, where so many grids have more voxels than the limit, which may be more than
/// can be counted. \param grids  [1] >= 1
void expect_few_samples(const GridGeometry& geometry, double grids, const Limit& limit);

/// The same where they need more memory than is free, as floats.
/// \param components  [1] of each voxel, copies included
/// \param right       what would be right, the end of the sentence
void expect_memory(const GridGeometry& geometry, double grids, int components, std::string_view right);

}  // namespace palpa::detail
