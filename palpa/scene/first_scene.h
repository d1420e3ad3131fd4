// First scene: a commented scene file for new data.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpa/data/statistics.h"
#include "palpa/data/volume.h"

namespace palpa {

/// Number of the first field to feel or show: a vector field that is not 0 everywhere, preferably a velocity; else the first
/// scalar field that varies; else none.
/// \param values  statistics of each field
std::optional<std::size_t> field_to_feel(const Volume& volume, const std::vector<Statistics>& values);

/// Options of a first scene.
struct FirstSceneOptions {
  std::filesystem::path folder{};  ///< of the scene's file: files given by a relative path, or in that folder or below, are
                                   ///< written relative to it, so that both can be moved; empty: all paths are absolute
  std::string volume{};            ///< name of the volume, a plain word; empty: by its file
  std::vector<std::pair<std::string, double>> labels{};  ///< names of values, in the field's own unit
  const Volume* beside = nullptr;  ///< second volume, read from a file: its fields may bound a flow, as in one volume
};

/// A scene file for a volume, with a reason for every number in a comment.
///
/// A vector field is felt as a flow: a rail along it, and drag, both only within the flow. A label map is felt as a surface for
/// each of its largest labels. Another scalar field is felt as surfaces, with drag within the solid: skin and bone for
/// Hounsfield units, else the levels that divide its histogram best, the firmer the sharper their edges. `field_to_feel`
/// selects the field. The hand's reach is the object, without small parts beside it (a table, specks). All strengths together,
/// friction and the drag of a hand at 0.4 m/s stay below the force limit.
///
/// \param volume   as it was read, trilinear
/// \param request  request that it was read by, written into the scene
/// The text contains no data of the file but its path, the names and units of its arrays and numbers: no patient's name. Reads
/// all voxels a few times. Throws LoadError, without a place, if there is nothing to feel, or if the path is no UTF-8, which no
/// scene can name.
std::string first_scene(const Volume& volume, const VolumeRequest& request, const FirstSceneOptions& options = {});

}  // namespace palpa
