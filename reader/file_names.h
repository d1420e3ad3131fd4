// Formats whose files have no mark: their names say what they are.
#pragma once

#include <cstdint>
#include <filesystem>

namespace palpa::reader {

/// The folder of the case of OpenFOAM that a path means: itself, or that of a file that marks it (".foam",
/// "system/controlDict"); empty where it means none.
std::filesystem::path openfoam_case(const std::filesystem::path& path);

enum class Plot3dPart : std::uint8_t { unknown, grid, solution };

/// Which file of PLOT3D it is by its name.
Plot3dPart plot3d_part(const std::filesystem::path& path);

/// The other file of the two, by the names that people give them; empty where there is none.
std::filesystem::path plot3d_partner(const std::filesystem::path& path);

}  // namespace palpa::reader
