// Frames at equal distances in time, as one field.
#pragma once

#include <cstdint>
#include <vector>

#include "palpa/time/timed_field.h"

namespace palpa {

/// What lies between two frames.
enum class BetweenFrames : std::uint8_t {
  linear,   ///< values and derivatives blended; a level moves with it where it shifts by less than its edge is wide
  nearest,  ///< the nearer frame: everything jumps in the middle
};

/// Frames of one grid or box at equal distances in time: frame i at i · period. Looped, the last frame is followed by the
/// first, one period later, and blends into it; else there is nothing before the first and after the last.
///
/// A linear blend is one of values, gradients, Jacobians and Hessians, so each of them stays the exact derivative of the
/// value at every moment; at a frame it is that frame, to the bit. A place is inside where both frames are.
/// A frame may not be timed itself. Keeps the frames: no memory beyond them.
///
/// \param frames    at least one; the same components, box and spacing
/// \param period_s  [s] from frame to frame, above 0 and finite
/// Reads 4096 places of the frames for the noise of their gradients. Throws std::invalid_argument, with a sentence.
FieldPtr time_series(std::vector<FieldPtr> frames, double period_s, BetweenFrames between_frames = BetweenFrames::linear);

/// Why a field cannot follow another one in a series, as the end of a sentence; nullptr if it can.
const char* problem_with_frame(const Field& first, const Field& frame) noexcept;

/// The frames behind a field made by `time_series`; nullptr for other fields.
struct SeriesView {
  std::vector<FieldPtr> frames;
  double period_s = 1.0;
  BetweenFrames between_frames = BetweenFrames::linear;
};
const SeriesView* series_of(const Field& field) noexcept;

}  // namespace palpa
