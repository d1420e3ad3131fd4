// Where the scenes that come with Palpa are.
#pragma once

#include <filesystem>

namespace palpa::app {

/// $PALPA_SCENES, or beside the program, installed or in a build folder. Throws LoadError where there are none.
std::filesystem::path scenes_folder();

}  // namespace palpa::app
