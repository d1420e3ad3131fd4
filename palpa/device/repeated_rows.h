// Rows of a recorded hand that repeat the position before them: a logger that is faster than its device, or an encoder at rest.
#pragma once

#include <span>

namespace palpa::detail {

/// A row whose position is not that of the row before it.
struct PositionChange {
  double step_m = 0.0;  ///< largest component of the step from the row before, > 0
  int rows = 1;         ///< since the last such row, >= 1; above 1 the rows between repeat its position
};

/// Whether the repeated rows come from a logger that is faster than its device, so that they say nothing; else they are an
/// encoder's, whose hand moves by less than a step from row to row. Told by their pattern, at any rate of rows:
/// a logger repeats each position about as often whether the hand is slow or fast, and the step that follows is as long as the
/// hand is fast; an encoder's rows repeat the longer the slower the hand is, and the step that follows is a single one.
/// Where the speed never changes the two look alike: a step longer than any haptic encoder's is then a logger's.
/// \param changes  of a whole recording, in their order
/// Allocates; any thread.
bool repeat_by_logger(std::span<const PositionChange> changes);

}  // namespace palpa::detail
