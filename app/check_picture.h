// Picture of `palpa check`: stable stiffness and damping.
#pragma once

#include <filesystem>

#include "palpa/base/new_file.h"
#include "palpa/study/check.h"

namespace palpa::app {

/// Draws the map into a PNG file. \param report  with its map. Throws LoadError.
void draw_check(const CheckReport& report, const std::filesystem::path& file, detail::Existing existing);

}  // namespace palpa::app
