// Feeling a scene headless, and feeling a trace again.
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpa/device/hand.h"
#include "palpa/scene/load_scene.h"
#include "palpa/study/summary.h"
#include "palpa/trace/trace.h"
#include "palpa/volume/read_volume.h"

namespace palpa {

struct RunOptions {
  std::filesystem::path scene;
  std::string hand;                          ///< file or sim:…
  std::optional<Hold> hold;
  RecordingOptions recording;
  std::optional<double> duration_s;          ///< none: the recording's, or 10
  double rate_hz = 1000.0;
  std::filesystem::path out;                 ///< trace folder; empty: none
  bool primitives = false;
  SceneOptions scene_options;
  ReadOptions read;
  std::vector<std::string> arguments;        ///< the command line, for the trace
};

struct RunResult {
  Summary summary;
  std::vector<std::string> warnings;
  bool interrupted = false;
};

/// Loads the scene, feels it with the hand, records it where asked. Throws LoadError.
RunResult run(const RunOptions& options, const std::atomic<bool>* stop = nullptr);

struct ReplayResult {
  TraceDifference difference;
  Summary summary;
};
/// Feels a trace again with its recorded time steps, probe, velocity, validity and buttons, and
/// compares. The new trace goes to a temporary folder that is removed. Throws LoadError.
ReplayResult replay(const std::filesystem::path& trace, const SceneOptions& scene_options, const ReadOptions& read);

}  // namespace palpa
