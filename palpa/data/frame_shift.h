// Displacement of a time series' levels from frame to frame, by the width of their edges.
#pragma once

#include <optional>

#include "palpa/data/timed_field.h"

namespace palpa {

/// Shift per frame over width of the edge [1]: a linear blend of two frames moves a level if its shift is much less than the
/// edge's width; beyond, it makes a jump.
struct FrameShift {
  int places = 0;           ///< examined, over all pairs of frames
  double median = 0.0;      ///< [edge widths per frame]
  double p90 = 0.0;         ///< [edge widths per frame]; infinity if so many edges have no match in the next frame
  double lost_share = 0.0;  ///< [1] of the places: no such edge in the next frame within 32 spacings along the gradient
};

/// Examines places on a level, or, without a level, the steepest tenth, in up to 20 pairs of frames. The width of an edge is
/// its whole rise along the gradient, while it rises at a tenth of its slope at least, over that slope; its shift the distance
/// along the gradient to the nearest equal value, also rising, in the next frame. For a scalar series; empty for others. Takes
/// up to seconds.
/// \param level  in the field's own unit
FrameShift frame_shift(const SeriesView& series, std::optional<double> level = {});

}  // namespace palpa
