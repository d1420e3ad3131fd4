// Whether two volumes are known to hold the same data.
#pragma once

#include "palpa/data/volume.h"

namespace palpa::detail {

/// Whether two volumes have the same files and fields, and the fields the same values everywhere, as far as is known without
/// reading them. Any thread.
/// \param same_origin  true: they were made by the same words of a scene, or read in the same way; false: only volumes that
/// share their voxels are known to be the same, because data from code have no origin
bool same_data(const Volume& a, const Volume& b, bool same_origin);

}  // namespace palpa::detail
