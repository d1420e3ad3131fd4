// Traces: recordings of a session that can be felt again (formats.md §3).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "palpa/trace/record.h"

namespace palpa {

/// What `trace.toml` says about a recording.
struct TraceHeader {
  bool complete = false;
  int format = 1;
  std::string palpa_version;
  std::vector<std::string> arguments;
  std::vector<std::pair<std::string, std::string>> sets;
  std::vector<std::string> plugins;
  Similarity hand_to_world;
  double dt_s = 1e-3;
  double device_max_force_n = 10.0;
  double device_max_stiffness_n_per_m = 1e5;
  double device_workspace_radius_m = 0.15;
  double device_encoder_step_m = 0.0;
  std::vector<SourceFile> data_files;
  std::vector<std::uint64_t> seeds;
  bool primitives = false;           ///< balances.csv and primitives.csv are there
};

/// Writes a trace into a new folder. Not for the tick: it formats and writes. What was appended is in
/// the operating system's hands after `flush`, and survives a kill.
class TraceWriter {
 public:
  /// Creates `folder` (its parent exists, it does not); throws LoadError where it cannot be written.
  TraceWriter(const std::filesystem::path& folder, const TraceHeader& header, const std::string& scene_text,
              std::vector<std::string> mode_names, std::vector<std::string> field_names);
  ~TraceWriter();

  /// One tick with what the session had to say of it.
  void append(const TickFrame& frame, std::span<const ModeTick> modes, std::span<const SubStep> sub_steps,
              std::span<const PlacedPrimitive> placed, std::span<const SessionEvent> events);
  /// An event of the loop: guard, lost_ticks, lost_rows, …
  void append_event(std::int64_t tick, double t_s, const std::string& kind, const std::string& subject, const std::string& value);
  void flush();
  /// Marks the trace as complete and closes it. Throws LoadError where the disk was full on the way.
  void finish();

 private:
  class Files;
  std::unique_ptr<Files> files_;
};

/// A tick as a reader finds it: the columns of ticks.csv.
struct TraceTick {
  TickFrame frame;
};

/// Reads a trace back, complete or not: each file up to its last whole line.
class TraceReader {
 public:
  /// Throws LoadError on a folder that is no trace.
  explicit TraceReader(const std::filesystem::path& folder);
  ~TraceReader();
  const TraceHeader& header() const noexcept;
  const std::string& scene_text() const noexcept;
  /// The ticks in order; unknown columns are skipped. Throws LoadError with file and line on a bad number.
  std::vector<TraceTick> ticks() const;

 private:
  std::filesystem::path folder_;
  TraceHeader header_;
  std::string scene_text_;
};

/// Where two traces first differ, over every CSV but timing.csv.
struct TraceDifference {
  bool same = true;
  std::string where;   ///< "ticks.csv:17: column force_x_n: 0.5 against 0.25"
  std::int64_t ticks = 0;
};
/// Compares up to the shorter one's last whole tick when `recorded` is incomplete.
TraceDifference compare_traces(const std::filesystem::path& recorded, const std::filesystem::path& again);

/// One column of a trace's file, for docs/trace.md.
std::string trace_reference_markdown();

}  // namespace palpa
