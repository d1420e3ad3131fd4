// Folder of the scenes that come with Palpa.
#pragma once

#include <filesystem>

namespace palpa {

/// $PALPA_SCENES, or beside the program, installed or in a build folder. Allocates; any thread. Throws LoadError if there are
/// none.
std::filesystem::path scenes_folder();

}  // namespace palpa
