// Volume table of a first scene: how it was read, its fields, and its filter.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "palpa/data/volume.h"
#include "palpa/scene/first_levels.h"

namespace palpa::detail {

/// Plain word for a name: replaces all but letters, digits, '_' and '-' by '_'; `otherwise` if that is none.
std::string plain_word(const std::string& name, const std::string& otherwise);

/// Names of a first scene's volume and fields.
struct SceneNames {
  std::string volume;
  std::vector<std::string> fields;    ///< of the volume, as plain words
  std::vector<std::size_t> used;      ///< their numbers, the felt field first
  bool only_one = false;              ///< the volume has a single field
  std::vector<std::string> beside{};  ///< whole names of the fields of a second volume, counted behind the first's

  std::string of(std::size_t field) const;
};
/// \param felt  number of the field that is felt
SceneNames names_of(const Volume& volume, const VolumeRequest& request, std::size_t felt);

/// Names of a second volume, read from a file, whose fields are added to `first`; none of them is used yet.
SceneNames names_beside(const Volume& volume, SceneNames& first);

/// The table without its filter. Throws LoadError, without a place, if a scene cannot name the file.
/// \param folder  as of `first_scene`
std::string volume_table(const Volume& volume, const VolumeRequest& request, const SceneNames& names,
                         const std::filesystem::path& folder);

/// Filter of a field that is felt as surfaces, and its cost; empty without voxels.
/// \param sample  as of `first_levels`
std::string filter_of_surfaces(const Field& field, std::span<const FieldPtr> sample, const std::vector<FirstLevel>& levels,
                               bool solid_is_high);
/// Filter of a flow with fractional values: trilinear, because smoothing would blur the edges of the scalar fields of masks.
/// Empty: the default.
std::string filter_of_flow(const Volume& volume);

}  // namespace palpa::detail
