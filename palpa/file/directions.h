// Directions that a file keeps as three frames.
#pragma once

#include <optional>

#include "palpa/file/read_volume.h"

namespace palpa {

/// How to ask for the three frames of an opened file where they are the components of vectors of length 1, as programs for
/// diffusion write directions: `as = "vector"`, and `components_along = "index"` where nothing is said and directions agree
/// better with those along them so, which is FSL's way and mirrors them if taken otherwise. Nothing for other files. Reads the
/// file twice more where it may be so. \param file  what `request` gave
std::optional<VolumeRequest> as_directions(const VolumeRequest& request, const VolumeFile& file,
                                           const ReadOptions& options = {});

}  // namespace palpa
