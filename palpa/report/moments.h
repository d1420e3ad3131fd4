// Moments of a trace that can be looked at closely, each with its primitives.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "palpa/report/recorded.h"

namespace palpa::detail {

/// One tick, looked at.
struct RecordedMoment {
  std::size_t row = 0;                      ///< of `Recorded::ticks`
  std::vector<PlacedPrimitive> primitives;  ///< of its last sub-step
};

/// The tick to look at first: most modes in contact, then the largest force on the hand. None: no mode pushed.
std::optional<std::size_t> busiest_row(const Recorded& recorded);

/// Rows of `recorded.ticks` in order, at most `most` [rows]: the busiest, those of the first events, and the rest evenly in
/// time.
std::vector<std::size_t> rows_worth_a_look(const Recorded& recorded, std::size_t most);

/// The moments at `rows`, which ascend, without primitives.
std::vector<RecordedMoment> moments_at(const std::vector<std::size_t>& rows);

/// Adds the primitives that the trace recorded.
void recall_primitives(const std::filesystem::path& trace, const Recorded& recorded, std::vector<RecordedMoment>& moments);

/// Adds them where they were not recorded: feels the trace once more, up to the last moment. Throws LoadError where the
/// proxy is not where it was; no moment has primitives then.
/// \param progress  is told the share that is done [1]
void feel_primitives_again(const std::filesystem::path& trace, const Recorded& recorded, const Scene& scene,
                           std::vector<RecordedMoment>& moments, const std::function<void(double)>& progress);

}  // namespace palpa::detail
