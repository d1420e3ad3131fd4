// Formats recognised by file names, because their contents have no mark.
#pragma once

#include <cstdint>
#include <filesystem>

namespace palpa::reader {

/// Folder of an OpenFOAM case: the path itself, or the case of a marker file (".foam", "system/controlDict"); empty if none.
std::filesystem::path openfoam_case(const std::filesystem::path& path);

enum class Plot3dPart : std::uint8_t { unknown, grid, solution };

/// Part of PLOT3D, by the file's name.
Plot3dPart plot3d_part(const std::filesystem::path& path);

/// Other file of the pair, by the usual names; empty if there is none.
std::filesystem::path plot3d_partner(const std::filesystem::path& path);

}  // namespace palpa::reader
