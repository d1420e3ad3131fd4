// Traces: whole ticks as they are recorded, and recordings of a session that can be felt again (formats: docs/trace.md).
#pragma once

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
#include "palpa/session/session.h"

namespace palpa {

/// What the guard did with a tick's force (docs/safety.md).
enum class GuardState : std::uint8_t {
  pass,     ///< let it through
  limited,  ///< shortened it to the limit, or held back how fast it grew or turned
  fault,    ///< it was not finite: nothing went out
  waiting,  ///< nothing goes out until what would be felt is small
  ramp,     ///< a growing share goes out
  damped,   ///< let it through with damping, as more energy came out than went in
  falling,  ///< what went out last goes to nothing
  off,      ///< nothing goes out until a person says so
};

/// Why the guard lets nothing or less through.
enum class GuardCause : std::uint8_t {
  none,
  start,         ///< the session has just begun, or a person lets it go on
  not_finite,    ///< the force is no number
  no_position,   ///< the device does not know where the hand is, or it is nowhere
  device_fault,  ///< the device says that something is wrong
  link_lost,     ///< the device did not take the last force
  late,          ///< three ticks or more were missed while motors held the last force
  speed,         ///< the hand is too fast
  view_moves,    ///< the view, the map from hand to data, or the clutch moves
  dead_man,      ///< the button that has to be held is not
  panic,         ///< a person said stop
  stops,         ///< the program is being stopped or ended
};

/// What the loop knows of a tick besides the probe; each a bit of `TickFrame::circumstances`.
enum class Circumstance : std::uint8_t { device_fault, link_lost, late, view_moves, panic, resume, new_scene, stops };
constexpr std::uint32_t bit_of(Circumstance circumstance) noexcept { return 1u << static_cast<unsigned>(circumstance); }

/// What these are called in files.
const char* name_of(GuardState state) noexcept;
const char* name_of(GuardCause cause) noexcept;
/// The cause as half a sentence for a person.
const char* words_of(GuardCause cause) noexcept;
const char* name_of(TickStatus status) noexcept;
const char* name_of(Stop stop) noexcept;
const char* name_of(SessionEventKind kind) noexcept;

/// What the loop knows of a tick: the session's answer and what became of it.
struct TickFrame {
  std::int64_t tick = 0;  ///< counts from 0
  double t_s = 0.0;       ///< since the session began
  double dt_s = 0.0;      ///< the time step that the session was given
  Tick result;
  Vec3 command_n;  ///< what was sent to the device: after the guard
  GuardState guard = GuardState::pass;
  GuardCause guard_cause = GuardCause::none;
  std::uint32_t circumstances = 0;  ///< bits of Circumstance
  double snap_n = 0.0;  ///< the step of the force as the proxy let go of something other than a level, if that is spread out
  std::uint32_t buttons = 0;
  double late_us = 0.0;    ///< how late the tick began; 0 on a simulated clock
  double tick_us = 0.0;    ///< time inside `Session::tick`; 0 where it was not measured
  double device_us = 0.0;  ///< time inside the device's read and write; 0 where it was not measured
};

/// What `trace.toml` says about a recording.
struct TraceHeader {
  bool complete = false;  ///< set by `TraceWriter::finish`, whatever the caller says
  int format = 1;
  std::string palpa_version;
  std::vector<std::string> arguments;
  std::vector<std::pair<std::string, std::string>> sets;
  std::vector<std::string> plugins;
  Similarity hand_to_world;  ///< read back to rounding: the file holds its 4×4 matrix
  double dt_s = 1e-3;        ///< nominal; every tick has its own
  std::string device_name;   ///< as it was described; empty: an ideal device
  double device_max_force_n = 10.0;
  double device_max_stiffness_n_per_m = 1e5;
  double device_workspace_radius_m = 0.15;
  double device_encoder_step_m = 0.0;
  bool motors = false;  ///< the guard stood between this session and a device: with its gate, its ramp and all else
  double device_continuous_force_n = std::numeric_limits<double>::infinity();
  double device_max_damping_ns_per_m = std::numeric_limits<double>::infinity();
  double device_damping_ns_per_m = 0.0;
  std::uint32_t dead_man_buttons = 0;
  std::vector<SourceFile> data_files;
  std::vector<std::uint64_t> seeds;  ///< below 2^63
  std::vector<std::string> notes;    ///< sentences for who reads of it: how the hand was laid, why little was felt
  bool primitives = false;           ///< balances.csv and primitives.csv are there
};

/// Writes a trace into a new folder. Not for the tick: it formats, writes and throws. What was
/// appended is in the operating system's hands after `flush`, and survives a kill of this process.
/// One thread.
class TraceWriter {
 public:
  /// Creates `folder` (its parent exists, it does not) with everything but ticks in it. Throws LoadError
  /// where that cannot be; nothing is left behind then.
  /// \param scene_text  the scene file, byte for byte
  /// \param mode_names  in the scene's order
  TraceWriter(const std::filesystem::path& folder, const TraceHeader& header, const std::string& scene_text,
              std::vector<std::string> mode_names);
  /// Writes what it can of what was appended. Without `finish` the trace stays incomplete, but readable.
  ~TraceWriter();
  TraceWriter(const TraceWriter&) = delete;
  TraceWriter& operator=(const TraceWriter&) = delete;

  /// Whether the sub-steps and primitives of ticks are wanted.
  bool records_primitives() const noexcept;

  /// One tick with what the session had to say of it; an event where the guard's state changes. Throws
  /// LoadError where the disk is full.
  void append(const TickFrame& frame, std::span<const ModeForce> modes, std::span<const SubStep> sub_steps,
              std::span<const PlacedPrimitive> placed, std::span<const SessionEvent> events);
  /// An event of the loop: warning, lost_ticks, lost_rows, …
  void append_event(std::int64_t tick, double t_s, const std::string& kind, const std::string& subject,
                    const std::string& value);
  /// A sentence more for the header's notes, which `finish` writes.
  void add_note(const std::string& note);
  /// Hands all whole rows to the operating system. Throws LoadError where the disk is full.
  void flush();
  /// Flushes, closes, and marks the trace as complete. Throws LoadError where the disk is, or on the
  /// way was, full: the trace then stays incomplete.
  void finish();

 private:
  class Files;
  std::unique_ptr<Files> files_;
};

/// A tick as a reader finds it: the columns of ticks.csv. The times of timing.csv stay 0.
struct TraceTick {
  TickFrame frame;
};

/// Reads a trace back, complete or not: each file up to its last whole line.
class TraceReader {
 public:
  /// Throws LoadError on a folder that is no trace.
  explicit TraceReader(const std::filesystem::path& folder);
  const TraceHeader& header() const noexcept { return header_; }
  const std::string& scene_text() const noexcept { return scene_text_; }
  /// The ticks in order. Columns are found by name, those that are not known skipped; those that came after the first traces
  /// read as 0 where a recording lacks them. Throws LoadError with file and line on any other missing column or a bad
  /// number.
  std::vector<TraceTick> ticks() const;
  /// Whether its ticks have all that an energy table is summed up from: older recordings do not. Throws as `ticks`.
  bool tells_energy() const;

 private:
  std::filesystem::path folder_;
  TraceHeader header_;
  std::string scene_text_;
};

/// Where two traces first differ, over scene.toml and every CSV but timing.csv.
struct TraceDifference {
  bool same = true;
  std::string where;       ///< "ticks.csv:17: column force_x_n: 0.5 against 0.25"; empty when the same
  std::int64_t ticks = 0;  ///< rows of ticks.csv that were compared
};
/// Compares a recording with `again`, which was felt from it. Where the recording is incomplete, its
/// whole lines are compared, up to its last whole tick, and `again` may go on. Throws LoadError on a
/// folder that is no trace. Columns that came after the first traces are compared where the recording has them.
/// \param last_tick  what the recording has of later ticks is left out
TraceDifference compare_traces(const std::filesystem::path& recorded, const std::filesystem::path& again,
                               std::int64_t last_tick = std::numeric_limits<std::int64_t>::max());

/// A number, or a vector, for every tick of a path.
struct FeltColumn {
  std::string name;            ///< its unit at the end: "force_n", "mode.skin.force_n"; without one: whole numbers
  int components = 1;          ///< 1, or 3 along the axes of the world
  bool is_whole = false;       ///< its values are whole numbers
  std::vector<double> values;  ///< in the column's own unit; the components of one tick together
};

/// What happened on a path.
struct FeltEvent {
  std::size_t row = 0;  ///< of the tick in the columns
  std::string kind;     ///< as in events.csv
  std::string subject;
  std::string value;
};

/// What was felt, tick by tick, in the frame of the data and not of the hand: for programs that show data. Forces keep their
/// newtons, and point where they point in the data.
struct FeltPath {
  /// As long as each other, in this order: tick, t_s, proxy_m, probe_m, probe_valid, force_n, command_n, error_bound_m, status
  /// (of TickStatus), guard (of GuardState), buttons; of each mode its mode.NAME.force_n and, where primitives were recorded,
  /// mode.NAME.strength_n: of its primitives in the last sub-step, added up; of each kind of event that there was, how many:
  /// event.KIND.
  std::vector<FeltColumn> columns;
  std::vector<FeltEvent> events;

  std::size_t ticks() const noexcept { return columns.front().values.size(); }
  /// Throws std::out_of_range where there is none of that name.
  const FeltColumn& column(std::string_view name) const;
};

/// Reads it from the trace in `folder`, complete or not. Throws LoadError as TraceReader does.
FeltPath felt_path(const std::filesystem::path& folder);

/// The files of a trace and their columns, as docs/trace.md shows them.
std::string trace_reference_markdown();

}  // namespace palpa
