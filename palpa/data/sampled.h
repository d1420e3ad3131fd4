// Any field as a grid.
#pragma once

#include "palpa/data/grid.h"
#include "palpa/data/timed_field.h"

namespace palpa {

/// Any field as a grid of float32 over its box, `longest` (2 to 1024) samples along the longest side, so
/// that data without a file go the same way as data from one. A sample where the field has no data is
/// NaN, so that its cells are outside. As many threads as there are cores. A timed field as it is at its first moment. Throws
/// std::invalid_argument on another `longest`.
FieldPtr sampled(const Field& field, int longest);
/// A timed field as a series of `frames` grids over its loop, each as `sampled` makes it: a formula becomes like data from
/// files. Throws std::invalid_argument, with a sentence, on a field that is not timed, or fewer than 1 or more than 1000
/// frames.
FieldPtr sampled(const FieldPtr& field, int longest, int frames, BetweenFrames between_frames = BetweenFrames::linear);
}  // namespace palpa
