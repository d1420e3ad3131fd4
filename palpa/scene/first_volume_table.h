// The table of a first scene's volume: how it was read, which of its fields are used, and what lies between voxels.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpa/data/volume.h"
#include "palpa/scene/first_levels.h"

namespace palpa::detail {

/// How a scene names what it feels.
struct SceneNames {
  std::string volume;
  std::vector<std::string> fields;  ///< of the volume, as plain words
  std::vector<std::size_t> used;    ///< their numbers, the felt one first
  bool only_one = false;            ///< the volume has no other

  std::string of(std::size_t field) const;
};
/// \param felt  number of the field that is felt
SceneNames names_of(const Volume& volume, const VolumeRequest& request, std::size_t felt);

/// All of the table but its filter. Throws LoadError, without a place, where a scene cannot name the file.
/// \param folder  as of `first_scene`
std::string volume_table(const Volume& volume, const VolumeRequest& request, const SceneNames& names,
                         const std::filesystem::path& folder);

/// The filter of a field that is felt as surfaces, and what that costs; empty where there are no voxels.
std::string filter_of_surfaces(const Field& field, const std::vector<FirstLevel>& levels, bool solid_is_high);
/// The filter of a flow whose numbers are fractions: trilinear, because a smoothing one would blur the edges of the scalar
/// fields that masks read. Empty: as it is without a word.
std::string filter_of_flow(const Volume& volume);

}  // namespace palpa::detail
