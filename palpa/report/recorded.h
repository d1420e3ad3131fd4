// A trace as a report looks at it: its rows in memory, and the numbers over them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "palpa/study/summary.h"
#include "palpa/trace/trace.h"

namespace palpa::detail {

/// A row of events.csv.
struct RecordedEvent {
  std::int64_t tick = 0;
  double t_s = 0.0;
  std::string kind;
  std::string subject;
  std::string value;
};

/// A level of a mode, as the scene names it.
struct NamedLevel {
  std::string mode;
  std::string name;
  double value = 0.0;  ///< in the field's own unit
};

/// What was recorded, as far as it goes. Nothing here needs the scene's data.
struct Recorded {
  TraceHeader header;
  std::string scene_text;
  std::string title;                           ///< of the scene; empty: it has none
  std::vector<NamedLevel> levels;              ///< those with a name
  std::vector<TickFrame> ticks;                ///< with the times of timing.csv
  std::vector<std::string> modes;              ///< in the order in which they were recorded
  std::vector<std::vector<ModeForce>> pushes;  ///< [mode][tick], as long as `ticks`
  std::vector<RecordedEvent> events;
  Summary summary;
  bool tells_energy = true;  ///< false: recorded before ticks told all of the energy
};

/// Reads the trace in `folder`. Throws LoadError on a folder that is no trace, and on a file in it that
/// cannot be read.
Recorded read_recorded(const std::filesystem::path& folder);

/// The primitives of the last sub-step of each of the ticks numbered `ticks`, which ascend, if the trace recorded them.
std::vector<std::vector<PlacedPrimitive>> recorded_primitives(const std::filesystem::path& folder, const Recorded& recorded,
                                                              std::span<const std::int64_t> ticks);

}  // namespace palpa::detail
