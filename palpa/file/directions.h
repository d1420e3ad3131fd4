// Directions in three frames of a file.
#pragma once

#include <optional>

#include "palpa/file/read_volume.h"

namespace palpa {

/// Request for the three frames of an opened file as the components of unit vectors, as diffusion programs write directions:
/// `as = "vector"`, and `components_along = "index"` if unspecified and directions agree better along them so: FSL's
/// convention, mirrored if misread. None for other files. Reads a candidate file twice more.
/// \param file  result of `request`
std::optional<VolumeRequest> as_directions(const VolumeRequest& request, const VolumeFile& file,
                                           const ReadOptions& options = {});

}  // namespace palpa
