// Files that a program has read itself.
#pragma once

#include "palpa/data/volume.h"

namespace palpa::c {

/// The part of a file's volume that a scene requests, under the scene's names. Throws LoadError for what takes palpa-read:
/// other units of length, frames, parts.
Volume requested(const Volume& file, const VolumeRequest& request);

}  // namespace palpa::c
