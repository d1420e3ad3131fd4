// Scene of a trace, with its recorded data.
#pragma once

#include <filesystem>
#include <vector>

#include "palpa/file/read_volume.h"
#include "palpa/scene/load_scene.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Loads the scene of the trace in `folder`, read by `trace`. Search order of a relative path: the trace, `data_folders`, the
/// recording's location. Throws LoadError, also on data other than the recorded ones.
/// \param has_all_hands  of a run of several hands the scene of all of them, not of the trace's alone
LoadedScene load_recorded_scene(const std::filesystem::path& folder, const TraceReader& trace,
                                const std::vector<std::filesystem::path>& data_folders, const ReadOptions& read,
                                const ModeCatalog& modes, bool has_all_hands = false);

}  // namespace palpa
