// Feeling a scene headless, and feeling a trace again.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
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

/// What a run in real time takes besides.
struct LiveRunOptions {
  bool rehearse = true;  ///< see LiveOptions, as the next three
  std::uint32_t clutch_buttons = 0;
  std::uint32_t dead_man_buttons = 0;  ///< one of these has to be held for a force; 0: none
  bool goes_on_at_border = false;
  std::filesystem::path devices_toml;  ///< what the user says of devices; empty: `device_notes_file()`
  /// Called some fifty times a second on the caller's thread, to show and to steer what is felt; false ends the run. May be
  /// empty.
  std::function<bool(LiveLoop&, LiveScene&)> watch;
};

/// Where a recorded hand lies in the workspace.
enum class Place : std::uint8_t {
  as_recorded,  ///< as its rows say
  centred,      ///< the middle of its box in the middle of the workspace
  fitted        ///< where it feels most; a motion wider than any device's reach is first made smaller
};
const char* name_of(Place place) noexcept;  ///< "as_recorded", …

struct RunOptions {
  std::filesystem::path scene;
  std::string hand;  ///< file or sim:…; empty: a person's, in a live run, or `target`
  /// A hand of the program's, in place of `hand`; never moved, and rigid unless `hold` says otherwise.
  std::shared_ptr<const Target> target;
  std::optional<Hold> hold;
  /// What a simulated hand holds, as `device_plant` reads it; empty: an ideal device. Without such a hand: the real device, as
  /// `device_description` reads it.
  std::string device;
  std::optional<LiveRunOptions> live;  ///< in real time, by the clock on the wall
  RecordingOptions recording;
  /// Of a recording; none: as recorded for one with the columns of our own ticks.csv, and where `recording.center` is false;
  /// centred where that is true; else fitted.
  std::optional<Place> place;
  /// None: a tick for each time from the recording's first row to its last, or 10; of a person's hand: until it is stopped.
  std::optional<double> duration_s;
  double rate_hz = 1000.0;    ///< [1, 1e5]
  std::filesystem::path out;  ///< trace folder; empty: none
  bool primitives = false;
  SceneOptions scene_options;
  std::vector<std::filesystem::path> plugins;  ///< shared libraries that bring modes; trusted
  ReadOptions read;
  std::vector<std::string> arguments;  ///< the command line, for the trace
  /// Called about every 1000 ticks with the share of the run that is done, 0…1; may be empty.
  std::function<void(double)> progress;
};

/// Where the words of earlier versions, fitted or not, put the recording of `options.hand`: one with the columns of our own
/// ticks.csv stays as it was recorded, another is fitted or else centred. Reads the file. Throws LoadError.
Place place_by_fit(const RunOptions& options, bool is_fitted);

/// A run that is ready to be felt: everything was loaded and fits together.
struct PreparedRun {
  LoadedScene loaded;
  std::string device;                     ///< what it holds, as it was described; empty: an ideal device
  std::unique_ptr<SimulatedDevice> hand;  ///< none: a person's, on `real_device`
  std::shared_ptr<const Target> target;   ///< where the hand wants to be: `hand` follows it
  std::unique_ptr<Device> real_device;    ///< with what the user's devices.toml says of it
  double duration_s = 0.0;
  bool ends_with_row = false;              ///< the duration is a recording's: a tick at its very end feels the last row
  std::optional<Reach> reach;              ///< what can be felt, if it was needed to place the hand
  std::optional<RecordingPlacement> laid;  ///< where the recording was laid, if it was
  bool goes_its_own_way = false;           ///< the hand is a recording that no force holds back
  std::string remedy;              ///< the option that would place_recording the recording where it feels most, if it was not
  std::vector<std::string> notes;  ///< what was done with the hand, and which levels it cannot press through: sentences
};
/// Loads scene and hand, places the hand where data can be felt (`Reach`), and checks all options, also whether the trace's
/// folder can be made. Writes no file. Throws LoadError.
PreparedRun prepare(const RunOptions& options);
/// The same in a scene that is loaded. Throws LoadError.
PreparedRun prepare(LoadedScene loaded, const RunOptions& options);
/// The share [1] of a run's progress that the search for the data is said to be.
inline constexpr double reach_progress = 0.3;
/// A forecast of what the hand of a run will feel: which share of its path is where something can be felt or, if that is next
/// to nothing, why.
std::string forecast(const PreparedRun& prepared);

struct RunResult {
  Summary summary;
  std::vector<std::string> warnings;
  bool interrupted = false;
  bool is_recording_lost = false;  ///< of a live run: the disk was full, say; a warning tells it
};

/// Loads the scene, feels it with the hand, and records that if `options.out` names a folder. Throws LoadError; a trace that
/// was begun then says that it is incomplete. `stop`, set from any thread, ends the run after the current tick: the trace up to
/// there is complete. A live run goes on where its recording cannot.
RunResult run(const RunOptions& options, const std::atomic<bool>* stop = nullptr);
/// The same of a run that is prepared by these options.
RunResult run(PreparedRun prepared, const RunOptions& options, const std::atomic<bool>* stop = nullptr);

struct ReplayResult {
  TraceDifference difference;
  Summary summary;
  bool interrupted = false;  ///< nothing was compared
  std::string cut;           ///< why the trace was felt and compared up to some tick only; empty: it was to its end
};
/// Feels a trace again with its recorded time steps, probes, velocities, validity and buttons, and compares the two traces. A
/// relative path of the scene is looked for in the trace, in `data_folders`, and where the recording found it; other data than
/// the recorded ones are an error. Plug-ins have to be named again: a trace may come from anybody, so that its plug-ins are not
/// loaded by themselves. The new trace is written to a temporary folder, which is removed. `progress` is called about every
/// 1000 ticks with the share that was felt, 0…1; may be empty. Throws LoadError.
ReplayResult replay(const std::filesystem::path& trace, const std::vector<std::filesystem::path>& data_folders = {},
                    const ReadOptions& read = {}, const std::atomic<bool>* stop = nullptr,
                    const std::vector<std::filesystem::path>& plugins = {}, const std::function<void(double)>& progress = {});

}  // namespace palpa
