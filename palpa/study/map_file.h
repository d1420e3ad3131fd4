// Maps of forces as files: for other programs, and for a run that goes on where an earlier one ended.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpa/base/new_file.h"
#include "palpa/scene/scene.h"
#include "palpa/study/map.h"

namespace palpa {

/// All that the numbers of a map depend on, as a text: the version, the scene with what was set in it, the checksums of its
/// data and plug-ins, and the lattice. Two maps of the same text have the same bytes. Throws LoadError on a plug-in that cannot
/// be read.
std::string identity_of_map(const Scene& scene, const std::vector<std::filesystem::path>& plugins, const MapLattice& lattice);

/// Where the ways that are done are kept beside a map that is not: its name with `.part` behind it.
std::filesystem::path kept_map_file(const std::filesystem::path& map);

/// Keeps the ways that are done, in place of what was kept before. Throws LoadError.
void keep_map(const ForceMap& map, const std::string& identity, const std::filesystem::path& file);

/// What was found of a map that was begun.
enum class KeptMap : std::uint8_t {
  none,     ///< there is no such file
  another,  ///< it is of another scene, other data, other places, or not whole: it may be replaced
  taken,    ///< its ways are in the map now
};
/// Puts the ways that were kept into a map of the same lattice, where they have the same identity. Throws LoadError on a file
/// that `keep_map` did not write: that is somebody else's.
KeptMap take_kept_map(ForceMap& map, const std::string& identity, const std::filesystem::path& file);

/// Writes a whole map as VTI, in the frame of the data as `palpa export` writes what was felt: metres, forces along the axes of
/// the world, in newtons. Throws LoadError with the file's name.
void write_map(const ForceMap& map, const Similarity& hand_to_world, const std::filesystem::path& file,
               detail::Existing existing);

}  // namespace palpa
