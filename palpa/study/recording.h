// How runs and replays begin a trace.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "palpa/scene/scene.h"
#include "palpa/trace/trace.h"
#include "palpa/volume/volume.h"

namespace palpa::detail {

/// The files behind a scene's volumes, in order, with absolute paths.
std::vector<SourceFile> data_files(const Scene& scene);

/// A trace of this scene, begun. Throws LoadError.
std::unique_ptr<TraceWriter> new_trace(const std::filesystem::path& folder, const TraceHeader& header,
                                       const std::string& scene_text, const Scene& scene);

}  // namespace palpa::detail
