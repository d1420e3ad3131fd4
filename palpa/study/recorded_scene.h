// The scene of a trace, with the data that it was felt with.
#pragma once

#include <filesystem>
#include <vector>

#include "palpa/file/read_volume.h"
#include "palpa/scene/load_scene.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Loads the scene of the trace in `folder`, read by `trace`. A relative path of the scene is looked for in
/// the trace, in `data_folders`, and where the recording found it. Throws LoadError, also where the data are
/// not the recorded ones.
LoadedScene load_recorded_scene(const std::filesystem::path& folder, const TraceReader& trace,
                                const std::vector<std::filesystem::path>& data_folders, const ReadOptions& read,
                                const ModeCatalog& modes);

}  // namespace palpa
