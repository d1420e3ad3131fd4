// A trace in memory, with its summary.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "palpa/study/summary.h"
#include "palpa/trace/trace.h"

namespace palpa::detail {

/// Row of events.csv.
struct RecordedEvent {
  std::int64_t tick = 0;
  double t_s = 0.0;
  std::string kind;
  std::string subject;
  std::string value;
};

/// Named level of a mode.
struct NamedLevel {
  std::string mode;
  std::string name;
  double value = 0.0;  ///< in the field's own unit
};

/// The complete or incomplete recording; independent of the scene's data.
struct Recorded {
  TraceHeader header;
  std::string scene_text;
  std::string title;                           ///< of the scene; empty: none
  std::vector<NamedLevel> levels;              ///< with a name
  std::vector<TickFrame> ticks;                ///< including timing.csv
  std::vector<std::string> modes;              ///< in recorded order
  std::vector<std::vector<ModeForce>> pushes;  ///< [mode][tick], as long as `ticks`
  std::vector<RecordedEvent> events;
  Summary summary;
  bool has_energy = true;  ///< false: recorded by a version with an incomplete energy ledger
};

/// Largest torques of a trace of a tool; zero for a point.
struct LargestTorques {
  double on_hand_nm = 0.0;   ///< sent to the device; 0: it drives none
  double coupling_nm = 0.0;  ///< before the guard
  double at_s = 0.0;         ///< time of the largest on the hand, or of the coupling's if the device drives none
};
/// Allocates nothing; any thread.
LargestTorques largest_torques(const Recorded& recorded) noexcept;

/// Reads the trace in `folder`. Throws LoadError on a folder that is no trace, and on an unreadable file.
Recorded read_recorded(const std::filesystem::path& folder);

/// Recorded primitives of the last sub-step of each of `ticks` (numbers, ascending); empty lists if none were recorded.
std::vector<std::vector<PlacedPrimitive>> recorded_primitives(const std::filesystem::path& folder, const Recorded& recorded,
                                                              std::span<const std::int64_t> ticks);

}  // namespace palpa::detail
