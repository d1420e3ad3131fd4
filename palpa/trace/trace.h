// Traces: recorded ticks, and recordings of a session for replay (formats: docs/trace.md).
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpa/data/volume.h"
#include "palpa/guard/guard_state.h"
#include "palpa/session/session.h"

namespace palpa {

/// Names in files.
const char* name_of(TickStatus status) noexcept;
const char* name_of(Stop stop) noexcept;
const char* name_of(SessionEventKind kind) noexcept;

/// The guard's result in one tick.
struct Command {
  Vec3 force_n;  ///< sent to the device
  GuardState guard = GuardState::pass;
  GuardCause cause = GuardCause::none;
  double snap_n = 0.0;  ///< step of the force as the proxy is released by something other than a level, if spread over time
  double work_on_hand_j = 0.0;  ///< work of the last tick's command until this tick
  double withheld_j = 0.0;      ///< likewise of the last tick's force and torque less its command
  Vec3 torque_nm{};             ///< sent to the device; zero where it drives no torque
  /// Energy that the hand's turning brought in since the last tick without feeling it, where the device drives no torque: minus
  /// the work of the last tick's torque on the turn, and minus its part of `withheld_j` (docs/theory.md 10.8).
  double unfelt_j = 0.0;
};

/// Energy [J] brought in by turning that a run reports (Command::unfelt_j). Less: rounding of a grip's turns counts; more: a
/// hand feels it before.
inline constexpr double told_unfelt_j = 1e-3;

/// Tick in the loop: the session's result, and the command made of it.
struct TickFrame {
  std::int64_t tick = 0;  ///< from 0
  double t_s = 0.0;       ///< since the session began
  double dt_s = 0.0;      ///< time step of the session
  Tick result;
  Command command;
  std::uint32_t circumstances = 0;  ///< bits of Circumstance
  std::uint32_t buttons = 0;
  WindowPlace laid{};      ///< of a volume larger than memory: the window that was laid before this tick, by a live loop
  double late_us = 0.0;    ///< lateness of the tick's start; 0 on a simulated clock
  double tick_us = 0.0;    ///< time inside `Session::tick`; 0 if not measured
  double device_us = 0.0;  ///< time inside the device's read and write; 0 if not measured
};

/// Content of `trace.toml`.
struct TraceHeader {
  bool complete = false;  ///< set by `TraceWriter::finish`; the caller's value is ignored
  int format = 1;
  std::string palpa_version;
  std::vector<std::string> arguments;
  std::string hand;  ///< of several hands the one of this trace, as in `arguments`; empty for one hand, or a device
  std::vector<std::pair<std::string, std::string>> sets;
  std::vector<std::string> plugins;
  Similarity hand_to_world;  ///< parsed to rounding: the file holds its 4×4 matrix
  double dt_s = 1e-3;        ///< nominal; every tick has its own
  std::string device_name;   ///< its description; empty: an ideal device
  double device_max_force_n = 10.0;
  double device_max_stiffness_n_per_m = 1e5;
  double device_workspace_radius_m = 0.15;
  double device_encoder_step_m = 0.0;
  bool motors = false;  ///< the full guard was between this session and a device, with its gate and ramp
  double device_continuous_force_n = std::numeric_limits<double>::infinity();
  double device_max_damping_ns_per_m = std::numeric_limits<double>::infinity();
  double device_damping_ns_per_m = 0.0;
  double device_max_torque_nm = 0.0;  ///< of a tool, as the next; 0: it drives no torque
  double device_max_turn_damping_nms_per_rad = std::numeric_limits<double>::infinity();
  std::uint32_t dead_man_buttons = 0;
  std::vector<SourceFile> data_files;  ///< a checksum that is not known yet is added by a later `flush`, or `finish`
  std::vector<std::uint64_t> seeds;    ///< below 2^63
  std::vector<std::string> notes;      ///< sentences for the reader: placement of the hand, reasons for little contact
  bool primitives = false;             ///< balances.csv and primitives.csv exist
  bool has_tool = false;               ///< a tool with an orientation: ticks.csv and the others have its columns, which say so
  bool has_octaves = false;            ///< a volume is larger than memory: likewise
};

struct TracedField;

/// Whether the trace is of one of a scene's several hands. Any thread.
inline bool is_one_of_several(const TraceHeader& header) noexcept {
  return std::ranges::any_of(header.sets, [](const auto& set) { return set.first == "only_hand"; });
}

/// Writes a trace into a new folder. Not in a tick: it formats, writes and throws. `flush` passes the appended data to the
/// operating system, where they survive a kill of this process. One thread.
class TraceWriter {
 public:
  /// Creates `folder` (its parent exists, it does not) with everything but ticks. On failure throws LoadError and leaves
  /// nothing behind.
  /// \param scene_text  the scene file, byte for byte
  /// \param mode_names  in the scene's order
  TraceWriter(const std::filesystem::path& folder, const TraceHeader& header, const std::string& scene_text,
              std::vector<std::string> mode_names);
  /// Records windows and chunks of fields larger than memory as well (palpa/trace/windows.h).
  TraceWriter(const std::filesystem::path& folder, const TraceHeader& header, const std::string& scene_text,
              std::vector<std::string> mode_names, std::vector<TracedField> octaves);
  /// Writes appended data as far as possible. Without `finish` the trace stays incomplete, but readable.
  ~TraceWriter();
  TraceWriter(const TraceWriter&) = delete;
  TraceWriter& operator=(const TraceWriter&) = delete;

  /// Whether sub-steps and primitives of ticks are recorded.
  bool records_primitives() const noexcept;

  /// Appends a tick with the session's records; an event on a change of the guard's state. Throws LoadError if the disk is
  /// full.
  void append(const TickFrame& frame, std::span<const ModeForce> modes, std::span<const SubStep> sub_steps,
              std::span<const PlacedPrimitive> placed, std::span<const SessionEvent> events);
  /// Appends an event of the loop: warning, lost_ticks, lost_rows, …
  void append_event(std::int64_t tick, double t_s, const std::string& kind, const std::string& subject,
                    const std::string& value);
  /// Adds a sentence to the header's notes, which `finish` writes.
  void add_note(const std::string& note);
  /// Passes all whole rows to the operating system. Throws LoadError if the disk is full.
  void flush();
  /// Flushes, closes, and marks the trace as complete; waits for the data's checksums. Throws LoadError if the disk is, or was
  /// meanwhile, full: the trace then stays incomplete.
  void finish();

 private:
  class Files;
  std::unique_ptr<Files> files_;
};

/// Tick as read: the columns of ticks.csv. The times of timing.csv stay 0.
struct TraceTick {
  TickFrame frame;
};

/// Reads a trace, complete or not: each file up to its last whole line.
class TraceReader {
 public:
  /// Throws LoadError if the folder is no trace.
  explicit TraceReader(const std::filesystem::path& folder);
  const TraceHeader& header() const noexcept { return header_; }
  const std::string& scene_text() const noexcept { return scene_text_; }
  /// Ticks in order. Columns are found by name, unknown ones skipped; later ones read as 0 if missing. Throws LoadError with
  /// file and line on any other missing column or a bad number.
  std::vector<TraceTick> ticks() const;
  /// Whether its ticks have all columns of an energy table: older recordings do not. Throws as `ticks`.
  bool has_energy() const;

 private:
  std::filesystem::path folder_;
  TraceHeader header_;
  std::string scene_text_;
};

/// Traces in a folder: of a run of several hands those of the hands, by name; else the folder itself, a trace or not.
std::vector<std::filesystem::path> traces_in(const std::filesystem::path& folder);

/// First difference of two traces, over scene.toml and every CSV but timing.csv.
struct TraceDifference {
  bool same = true;
  std::string where;       ///< "ticks.csv:17: column force_x_n: 0.5 against 0.25"; empty without
  std::int64_t ticks = 0;  ///< compared rows of ticks.csv
};
/// Compares a recording with its replay `again`. Of an incomplete recording the whole lines are compared, up to its last whole
/// tick, and `again` may continue. Throws LoadError if a folder is no trace. Later columns are compared if the recording has
/// them.
/// \param last_tick  later ticks of the recording are ignored
TraceDifference compare_traces(const std::filesystem::path& recorded, const std::filesystem::path& again,
                               std::int64_t last_tick = std::numeric_limits<std::int64_t>::max());

/// Number, or vector, for every tick of a path.
struct FeltColumn {
  std::string name;    ///< with its unit as suffix: "force_n", "mode.skin.force_n"; without one: whole numbers
  int components = 1;  ///< 1, 3 along the axes of the world, or 4 of a turn in the world: w, x, y, z
  bool is_whole = false;
  std::vector<double> values;  ///< in the column's own unit; the components of a tick together
};

/// Event on a path.
struct FeltEvent {
  std::size_t row = 0;  ///< of the tick in the columns
  std::string kind;     ///< as in events.csv
  std::string subject;
  std::string value;
};

/// Felt quantities by tick, in the frame of the data, not of the hand: for programs that show data. Forces keep their newtons,
/// with directions in the data.
struct FeltPath {
  /// Of equal lengths, in this order: tick, t_s, proxy_m, probe_m, probe_valid, force_n, command_n, error_bound_m, status (of
  /// TickStatus), guard (of GuardState), buttons; of each mode mode.NAME.force_n and, if primitives were recorded,
  /// mode.NAME.strength_n: the sum over its primitives in the last sub-step; of each kind of event present, its count:
  /// event.KIND. Of a tool with an orientation, after `buttons`: probe_turn, proxy_turn, torque_nm, command_torque_nm.
  std::vector<FeltColumn> columns;
  std::vector<FeltEvent> events;

  std::size_t ticks() const noexcept { return columns.front().values.size(); }
  /// Throws std::out_of_range for an unknown name.
  const FeltColumn& column(std::string_view name) const;
};

/// Reads the path of the trace in `folder`, complete or not. Throws LoadError as TraceReader does.
FeltPath felt_path(const std::filesystem::path& folder);

/// Files of a trace and their columns, for docs/trace.md.
std::string trace_reference_markdown();

}  // namespace palpa
