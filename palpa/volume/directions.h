// Directions that a file keeps as three frames.
#pragma once

#include "palpa/volume/read_volume.h"

namespace palpa {

/// Whether the three frames of an opened file are the components of vectors of length 1, as programs for diffusion write
/// directions: then `as = "vector"` is what a person would ask for. Reads the file once more where it may be so; false
/// where that cannot be read. \param file  what `request` gave
bool frames_are_directions(const VolumeRequest& request, const VolumeFile& file, const ReadOptions& options = {});

}  // namespace palpa
