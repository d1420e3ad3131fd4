// Header of NIfTI-1 files.
#pragma once

#include <string>

#include "palpa/file/write_volume.h"

namespace palpa::detail {

/// The 352 bytes before the voxels of a single file, for the first field: the grid as an sform, in millimetres along RAS, with
/// shear and mirroring. Vectors are along RAS, each component behind the other. Throws LoadError, without a place, beyond 32767
/// voxels along an axis.
std::string nifti_header(const WrittenVolume& volume);

}  // namespace palpa::detail
