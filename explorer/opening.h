// Opens a scene, data or a trace.
#pragma once

#include <filesystem>
#include <vector>

#include "explorer/document.h"
#include "palpa/file/read_volume.h"

namespace palpa::explorer {

/// Loads a scene file; for data, the scene that `palpa info --scene` suggests; for a trace, its scene. Any thread; duration
/// grows with the data. Throws LoadError, also when stopped.
/// \param data_folders  searched for the scene's files
Opened open_any(const std::filesystem::path& path, const std::vector<std::filesystem::path>& data_folders,
                std::stop_token stop = {});

/// Scenes installed with Palpa that need no files, "head_phantom.toml"; empty if not found.
std::vector<std::filesystem::path> embedded_scenes();

}  // namespace palpa::explorer
