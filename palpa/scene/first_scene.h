// A first scene for data that nobody has felt yet.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpa/data/statistics.h"
#include "palpa/data/volume.h"

namespace palpa {

/// The number of the field that is felt, or looked at, first: a vector field that is not 0 everywhere, one named as a velocity
/// before others; else the first scalar field that varies. None where no field does. \param values  statistics of each field
std::optional<std::size_t> field_to_feel(const Volume& volume, const std::vector<Statistics>& values);

/// A scene file for a volume, as text with a comment for every number: the reason why it is so.
///
/// A vector field is felt as a flow: a rail along it, and drag, both only where it flows. A label map is felt as a surface for
/// each of its largest labels. Another scalar field is felt as surfaces, with drag within what is solid: skin and bone where
/// the values are Hounsfield units, else the levels that divide its histogram best, the firmer the sharper their edges. Which
/// field: `field_to_feel`. The hand's reach is the object, which leaves out small parts beside it (a table, specks). All
/// strengths together, friction and the drag of a hand at 0.4 m/s stay below the force limit.
///
/// \param volume   as it was read, trilinear
/// \param request  what it was read by; all of it is written into the scene
/// \param folder   that the scene's file lies in: files that were named by a relative path, or lie in that folder or below, are
/// written relative to it, so that both can be moved; empty: all paths are absolute
/// Nothing of the file but its path, the names and units of its arrays and numbers gets into the text: no patient's name.
/// Reads all voxels a few times. Throws LoadError, without a place, where there is nothing to feel, or where the path is no
/// UTF-8, which no scene can name.
std::string first_scene(const Volume& volume, const VolumeRequest& request, const std::filesystem::path& folder = {});

}  // namespace palpa
