// Whether two volumes are known to hold the same data.
#pragma once

#include "palpa/volume/volume.h"

namespace palpa::detail {

/// Whether two volumes have the same files and fields, and the fields the same values everywhere, as far as is known without
/// reading them. Any thread.
/// \param same_origin  they were made by the same words of a scene, or read in the same way; else, as data from code have no
/// origin, only the same voxels are known to be the same
bool same_data(const Volume& a, const Volume& b, bool same_origin);

}  // namespace palpa::detail
