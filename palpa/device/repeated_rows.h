// Repeated positions in rows of a recorded hand: from a logger faster than its device, or an encoder at rest.
#pragma once

#include <span>

namespace palpa::detail {

/// Row with a position other than the row before.
struct PositionChange {
  double step_m = 0.0;  ///< largest component of the step from the row before, > 0
  int rows = 1;         ///< since the last such row, >= 1; above 1 the rows between repeat its position
};

/// Whether repeated rows come from a logger faster than its device, and so carry no information; else they are an encoder's,
/// from a hand slower than a step per row. Decided by their pattern, at any rate of rows: a logger repeats positions about
/// equally often at any speed of the hand, and the next step is proportional to the speed; an encoder's repeats grow as the
/// hand slows, and the next step is a single one. At constant speed both are alike: a step longer than any haptic encoder's is
/// then a logger's.
/// \param changes  of a whole recording, in order
/// Allocates; any thread.
bool repeat_by_logger(std::span<const PositionChange> changes);

}  // namespace palpa::detail
