// Label maps: fields whose values are numbers of parts, not amounts.
#pragma once

#include "palpa/field/statistics.h"

namespace palpa {

/// Whether the values of a scalar field on a grid are numbers of parts: whole, from 0 on, no more than 256 different ones,
/// and those of neighbours nearly always the same, as those of a measurement are not. Looks at some thousand rows of voxels.
bool looks_like_labels(const Field& field, const Statistics& values);

}  // namespace palpa
