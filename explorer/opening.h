// Opening what a person names: a scene, data, or a trace.
#pragma once

#include <filesystem>
#include <vector>

#include "explorer/document.h"
#include "palpa/file/read_volume.h"

namespace palpa::explorer {

/// Loads a scene file; for data the scene that `palpa info --scene` suggests; of a trace its scene. Any thread; takes as long
/// as the data are large. Throws LoadError, also when it is asked to stop.
/// \param data_folders  searched for the files of a scene
Opened open_any(const std::filesystem::path& path, const std::vector<std::filesystem::path>& data_folders,
                std::stop_token stop = {});

/// The scenes that come with Palpa and need no files, "head_phantom.toml"; empty where they were not found.
std::vector<std::filesystem::path> embedded_scenes();

}  // namespace palpa::explorer
