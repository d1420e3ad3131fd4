// Formats that are told by the names of files, because their contents have no mark.
#pragma once

#include <cstdint>
#include <filesystem>

namespace palpa::reader {

/// The folder of the OpenFOAM case that a path names: the path itself, or the case of a file that marks one (".foam",
/// "system/controlDict"); empty if it names none.
std::filesystem::path openfoam_case(const std::filesystem::path& path);

enum class Plot3dPart : std::uint8_t { unknown, grid, solution };

/// Which file of PLOT3D it is by its name.
Plot3dPart plot3d_part(const std::filesystem::path& path);

/// The other file of the two, by the usual pairs of names; empty if there is none.
std::filesystem::path plot3d_partner(const std::filesystem::path& path);

}  // namespace palpa::reader
