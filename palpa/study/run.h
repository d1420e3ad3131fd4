// Headless runs of a scene, and replays of a trace.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "palpa/device/hand.h"
#include "palpa/file/read_volume.h"
#include "palpa/loop/loop.h"
#include "palpa/scene/load_scene.h"
#include "palpa/study/reach.h"
#include "palpa/study/summary.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Further options of a run in real time.
struct LiveRunOptions {
  bool rehearse = true;  ///< see LiveOptions, likewise the next three
  std::uint32_t clutch_buttons = 0;
  std::uint32_t dead_man_buttons = 0;  ///< a force requires one of these; 0: none
  bool goes_on_at_border = false;
  std::filesystem::path devices_toml;  ///< the user's notes on devices; empty: `device_notes_file()`
  /// Called some fifty times a second on the caller's thread, for display and control, with the scene of each hand; false ends
  /// the run. May be empty.
  std::function<bool(LiveLoop&, std::span<LiveScene* const>)> watch;
  /// Called after every tick of each hand, on the loop's thread: it must neither allocate nor block. May be empty.
  HandObserver observer;
};

/// Placement of a recorded hand in the workspace.
enum class Place : std::uint8_t {
  as_recorded,  ///< as in its rows
  centred,      ///< centre of its box in the centre of the workspace
  fitted        ///< most contact; a motion wider than any device's reach is scaled down first
};
const char* name_of(Place place) noexcept;  ///< "as_recorded", …

struct RunOptions {
  std::filesystem::path scene;
  std::string hand;  ///< file or sim:…; empty: a person's, in a live run, or `target`
  /// Hand of the program, in place of `hand`; never displaced, and rigid unless `hold` is set.
  std::shared_ptr<const Target> target;
  std::optional<Hold> hold;
  /// Device in a simulated hand, as for `device_plant`; empty: an ideal device. Without such a hand: the real device, as for
  /// `device_description`.
  std::string device;
  std::optional<LiveRunOptions> live;  ///< in real time
  RecordingOptions recording;
  /// Of a recording; none: as recorded if it has the columns of a trace's ticks.csv, or `recording.center` is false; centred if
  /// that is true; else fitted.
  std::optional<Place> place;
  /// None: a tick for each time from the recording's first row to its last, or 10; of a person's hand: until stopped.
  std::optional<double> duration_s;
  double rate_hz = 1000.0;    ///< [1, 1e5]
  std::filesystem::path out;  ///< trace folder; empty: none
  bool primitives = false;
  SceneOptions scene_options;
  std::vector<std::filesystem::path> plugins;  ///< shared libraries with modes; trusted
  ReadOptions read;
  std::vector<std::string> arguments;  ///< the command line, for the trace
  /// Called about every 1000 ticks with the share done, 0…1; may be empty.
  std::function<void(double)> progress;
};

/// Place by the fit option of earlier versions for the recording of `options.hand`: with the columns of a trace's ticks.csv as
/// recorded, else fitted or centred. Reads the file. Throws LoadError.
Place place_by_fit(const RunOptions& options, bool is_fitted);

/// Run ready to start: loaded and validated.
struct PreparedRun {
  LoadedScene loaded;
  std::string device;                     ///< device in the hand, as described; empty: an ideal device
  std::unique_ptr<SimulatedDevice> hand;  ///< none: a person's, on `real_device`
  std::shared_ptr<const Target> target;   ///< intended position, followed by `hand`
  std::unique_ptr<Device> real_device;    ///< with the notes of the user's devices.toml
  double duration_s = 0.0;
  bool ends_with_row = false;              ///< the duration is a recording's: a tick at its very end has the last row
  std::optional<Reach> reach;              ///< contact in reach, if needed to place the hand
  std::optional<RecordingPlacement> laid;  ///< placement of the recording, if any
  bool is_rigid_hand = false;              ///< the hand is a rigid recording
  std::string remedy;                      ///< option that would place the recording at most contact, if unused
  std::vector<std::string> notes;          ///< sentences: losses of a named filter, treatment of the hand, unyielding levels
};
/// Loads scene and hand, places the hand in contact (`Reach`), and checks all options, also whether the trace's folder can be
/// created. Writes no file. Throws LoadError.
PreparedRun prepare(const RunOptions& options);
/// Prepares a run in a loaded scene. Throws LoadError.
PreparedRun prepare(LoadedScene loaded, const RunOptions& options);
/// Share [1] of a run's progress for the search for contact.
inline constexpr double reach_progress = 0.3;
/// Forecast of a run: the share of its path in contact or, if almost none, the reason.
std::string forecast(const PreparedRun& prepared);

struct RunResult {
  Summary summary;
  std::vector<std::string> warnings;
  bool interrupted = false;
  bool is_recording_lost = false;  ///< of a live run, by a full disk; a warning reports it
};

/// Loads the scene, runs it with the hand, and records that if `options.out` names a folder. Throws LoadError; a trace in
/// progress is then marked incomplete. `stop`, set from any thread, ends the run after the current tick: the trace up to there
/// is complete. A live run continues if its recording fails.
RunResult run(const RunOptions& options, const std::atomic<bool>* stop = nullptr);
/// Runs a run prepared with these options.
RunResult run(PreparedRun prepared, const RunOptions& options, const std::atomic<bool>* stop = nullptr);

/// Run of several hands on one clock, ready to start; in the order of the scene.
struct PreparedHands {
  std::vector<std::string> names;
  std::vector<RunOptions> options;  ///< of each hand, with its trace in a folder of its name
  std::vector<PreparedRun> runs;    ///< each in the scene of its hand
};
/// Loads the scene once, and prepares each of its hands. The hands that `options` name are ignored.
/// \param hands    as `RunOptions::hand`, one for each hand of the scene in its order, or `NAME=…` in any
/// \param devices  likewise as `RunOptions::device`: of the hands named by `hands`, or a person's
/// Throws LoadError, also if a hand of the scene has none or if there are more.
PreparedHands prepare_hands(const RunOptions& options, const std::vector<std::string>& hands,
                            const std::vector<std::string>& devices);
/// Runs all hands in one loop, until the last of them ends; a result for each. Otherwise as `run`.
std::vector<RunResult> run_hands(PreparedHands prepared, const std::atomic<bool>* stop = nullptr);

struct ReplayResult {
  TraceDifference difference;
  Summary summary;
  bool interrupted = false;  ///< no comparison
  std::string cut;           ///< reason why replay and comparison ended at some tick; empty: complete
};
/// Replays a trace with its recorded time steps, probes, velocities, validity and buttons, and compares the two traces. Search
/// order of a relative path of the scene: the trace, `data_folders`, the recording's location; other data than the recorded
/// ones are an error. Plug-ins have to be named again: traces are untrusted, so that their plug-ins are not loaded. The new
/// trace is written to a temporary folder, then removed. `progress` is called about every 1000 ticks with the share done, 0…1;
/// may be empty. Throws LoadError.
ReplayResult replay(const std::filesystem::path& trace, const std::vector<std::filesystem::path>& data_folders = {},
                    const ReadOptions& read = {}, const std::atomic<bool>* stop = nullptr,
                    const std::vector<std::filesystem::path>& plugins = {}, const std::function<void(double)>& progress = {});

}  // namespace palpa
