// How runs and replays begin a trace.
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

/// The files behind a scene's volumes, in order, with absolute paths.
std::vector<SourceFile> data_files(const Scene& scene);

/// A trace of this scene, begun. Throws LoadError.
std::unique_ptr<TraceWriter> new_trace(const std::filesystem::path& folder, const TraceHeader& header,
                                       const std::string& scene_text, const Scene& scene);

/// What a trace of this run says of itself. \param limits  of the device
TraceHeader header_of(const RunOptions& options, const PreparedRun& prepared, const DeviceLimits& limits);

/// The trace of a run while it is written; nothing where none is wanted.
class Recording {
 public:
  /// Throws LoadError where the trace cannot be begun.
  Recording(const RunOptions& options, const TraceHeader& header, const LoadedScene& loaded);
  Recorder* recorder() const { return recorder_.get(); }  ///< nullptr: nothing is recorded
  TraceWriter* writer() const { return writer_.get(); }   ///< nullptr: nothing is recorded
  /// No tick comes any more. Throws what the writer threw.
  void finish_ticks();
  /// Nothing comes any more. Throws LoadError where the disk is full.
  void finish();
  /// What was recorded stays; no more is.
  void give_up();

 private:
  std::unique_ptr<TraceWriter> writer_;
  std::unique_ptr<Recorder> recorder_;
};

/// The guard that stood between the recorded session and its device.
GuardOptions guard_options_of(const TraceHeader& header);

/// Why a recorded tick cannot be felt again: ticks before it were not recorded, or another scene was felt from there on. Empty:
/// it can. \param before  the tick recorded before it, or nullptr
std::string what_cannot_be_felt_again(const TickFrame* before, const TickFrame& recorded, double nominal_dt_s);

}  // namespace palpa::detail
