// Start of traces by runs and replays.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "palpa/data/volume.h"
#include "palpa/loop/loop.h"
#include "palpa/scene/scene.h"
#include "palpa/study/run.h"
#include "palpa/trace/trace.h"

namespace palpa::detail {

/// Files of a scene's volumes, in order, with absolute paths.
std::vector<SourceFile> data_files(const Scene& scene);

/// Starts a trace of this scene. Throws LoadError.
std::unique_ptr<TraceWriter> new_trace(const std::filesystem::path& folder, const TraceHeader& header,
                                       const std::string& scene_text, const Scene& scene);

/// Trace header of this run. \param limits  of the device
TraceHeader header_of(const RunOptions& options, const PreparedRun& prepared, const DeviceLimits& limits);

/// Clamps the scene to the device's limits (`clamped_to`); reports the changes in `prepared.notes` and the header's, and sets
/// them in the trace's scene as well.
void hold_to(const DeviceLimits& limits, PreparedRun& prepared, TraceHeader& header);

/// Trace of a run in progress; empty without recording.
class Recording {
 public:
  /// Throws LoadError if the trace cannot be created.
  Recording(const RunOptions& options, const TraceHeader& header, const LoadedScene& loaded);
  Recorder* recorder() const { return recorder_.get(); }  ///< nullptr: no recording
  TraceWriter* writer() const { return writer_.get(); }   ///< nullptr: no recording
  /// Whether there is a recording, of a point: its files have no columns for a tool. Any thread.
  bool is_of_point() const noexcept { return is_of_point_; }
  /// Call after the last tick. Throws the writer's exception.
  void finish_ticks();
  /// Completes the trace. Throws LoadError if the disk is full.
  void finish();
  /// Stops recording; keeps the recorded part.
  void give_up();

 private:
  std::unique_ptr<TraceWriter> writer_;
  std::unique_ptr<Recorder> recorder_;
  bool is_of_point_ = false;
};

/// Guard between the recorded session and its device.
GuardOptions guard_options_of(const TraceHeader& header);

/// Reason why a recorded tick cannot be replayed: earlier ticks were not recorded, or the scene changed. Empty: it can. \param
/// before  previous recorded tick, or nullptr
std::string what_cannot_be_felt_again(const TickFrame* before, const TickFrame& recorded, double nominal_dt_s);

}  // namespace palpa::detail
