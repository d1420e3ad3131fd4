// Equality of the data of two volumes.
#pragma once

#include "palpa/data/volume.h"

namespace palpa::detail {

/// Whether two volumes have equal files and fields, with equal values everywhere, as far as provable without reading them. Any
/// thread.
/// \param same_origin  true: both come from equal text of a scene, or equal reading; false: only volumes with shared voxels are
/// equal, because data from code have no origin
bool same_data(const Volume& a, const Volume& b, bool same_origin);

}  // namespace palpa::detail
