// How far the levels of a time series move from frame to frame, by the width of their edges.
#pragma once

#include <optional>

#include "palpa/data/timed_field.h"

namespace palpa {

/// Shift per frame over width of the edge [1]: a linear blend of two frames moves a level that shifts by much less than the
/// edge is wide; of one that shifts by more it makes a jump.
struct FrameShift {
  int places = 0;           ///< that were looked at, over all pairs of frames
  double median = 0.0;      ///< [edge widths per frame]
  double p90 = 0.0;         ///< [edge widths per frame]; infinity where so many edges have no place in the next frame
  double lost_share = 0.0;  ///< [1] of the places: the next frame has no such edge within 32 spacings along the gradient
};

/// Looks at places on a level, or, without one, at the steepest tenth, in up to 20 pairs of frames. The width of an edge
/// is its whole rise along the gradient, as far as that goes on rising at a tenth of its slope at least, over that slope;
/// its shift the way along the gradient to the nearest place of the same value, rising the same way, in the next frame.
/// Of a scalar series; nothing is found in others. Takes up to seconds.
/// \param level  in the field's own unit
FrameShift frame_shift(const SeriesView& series, std::optional<double> level = {});

}  // namespace palpa
