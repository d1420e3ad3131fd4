// Selected moments of a trace with their primitives.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "palpa/report/recorded.h"

namespace palpa::detail {

/// One tick in detail.
struct RecordedMoment {
  std::size_t row = 0;                      ///< index in `Recorded::ticks`
  std::vector<PlacedPrimitive> primitives;  ///< of its last sub-step
};

/// Tick to show first: most modes in contact, then largest force on the hand. None: no mode pushed.
std::optional<std::size_t> busiest_row(const Recorded& recorded);

/// Ascending rows of `recorded.ticks`, at most `most` [rows]: the busiest, the first events, and the rest evenly in time.
std::vector<std::size_t> rows_worth_a_look(const Recorded& recorded, std::size_t most);

/// Moments at `rows` (ascending), without primitives.
std::vector<RecordedMoment> moments_at(const std::vector<std::size_t>& rows);

/// Fills in the recorded primitives.
void recall_primitives(const std::filesystem::path& trace, const Recorded& recorded, std::vector<RecordedMoment>& moments);

/// Fills in primitives that were not recorded, by replaying the trace up to the last moment. Throws LoadError if the proxy
/// deviates from the recording; `moments` is unchanged then.
/// \param progress  called with the finished share [1]
void feel_primitives_again(const std::filesystem::path& trace, const Recorded& recorded, const Scene& scene,
                           std::vector<RecordedMoment>& moments, const std::function<void(double)>& progress);

}  // namespace palpa::detail
