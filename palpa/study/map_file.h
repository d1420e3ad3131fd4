// Files of force maps: for other programs, and to continue an interrupted run.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpa/base/new_file.h"
#include "palpa/scene/scene.h"
#include "palpa/study/map.h"

namespace palpa {

/// Text of all that determines a map's numbers: the version, the scene with its settings, the checksums of its data and
/// plug-ins, and the lattice. Maps of equal text have equal bytes. Throws LoadError on an unreadable plug-in.
std::string identity_of_map(const Scene& scene, const std::vector<std::filesystem::path>& plugins, const MapLattice& lattice);

/// File of an unfinished map's paths: the map's name with the suffix `.part`.
std::filesystem::path kept_map_file(const std::filesystem::path& map);

/// File of a part of a map: the map's name with the suffix `.part-3`.
std::filesystem::path map_part_file(const std::filesystem::path& map, int part);
/// Files of parts of a map that are there, by their numbers. Allocates; reads the folder.
std::vector<std::filesystem::path> map_part_files(const std::filesystem::path& map);

/// Writes the finished paths, replacing the previous file. Throws LoadError.
void keep_map(const ForceMap& map, const std::string& identity, const std::filesystem::path& file);

/// State of an unfinished map.
enum class KeptMap : std::uint8_t {
  none,     ///< no such file
  another,  ///< other scene, data or positions, or truncated: may be replaced
  taken,    ///< its paths are now in the map
};
/// Adds kept paths to a map of an equal lattice and identity. Throws LoadError on a file not written by `keep_map`: it
/// belongs to others.
KeptMap take_kept_map(ForceMap& map, const std::string& identity, const std::filesystem::path& file);

/// Writes a complete map as VTI, in the frame of the data, with the conventions of `palpa export`: metres, forces along the
/// axes of the world, in newtons. Throws LoadError with the file's name.
void write_map(const ForceMap& map, const Similarity& hand_to_world, const std::filesystem::path& file,
               detail::Existing existing);

}  // namespace palpa
