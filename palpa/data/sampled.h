// Resampling of any field to a grid.
#pragma once

#include "palpa/data/grid.h"
#include "palpa/data/timed_field.h"

namespace palpa {

/// Field as a grid of float32 over its box, `longest` (2 to 1024) samples along the longest side, so that data without a file
/// are processed like data from files. A sample without data is NaN, so that its cells are outside. Uses all cores. A timed
/// field at its first moment. Throws std::invalid_argument on another `longest`.
FieldPtr sampled(const Field& field, int longest);
/// Timed field as a series of `frames` grids over its loop, each as from `sampled`. Throws std::invalid_argument, with a
/// sentence, on a field that is not timed, or fewer than 1 or more than 1000 frames.
FieldPtr sampled(const FieldPtr& field, int longest, int frames, BetweenFrames between_frames = BetweenFrames::linear);
}  // namespace palpa
