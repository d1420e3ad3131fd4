// The tables of a first scene's modes, and of the layers that show what they feel.
#pragma once

#include <string>
#include <vector>

#include "palpa/data/labels.h"
#include "palpa/data/statistics.h"
#include "palpa/scene/first_flow.h"
#include "palpa/scene/first_levels.h"
#include "palpa/scene/first_volume_table.h"

namespace palpa::detail {

/// A scalar field as surfaces, with drag within what is solid.
/// \param faint  where drag begins: of a sparse object a value that half of its box is beyond; else the first level
std::string surface_modes(const std::string& field, const Statistics& values, const FirstLevels& first, double faint);

/// The key of the volume that makes a field of each of the largest labels.
std::string labels_line(const LabelMap& map);
/// A surface for each of these, with drag within all labels. \param field  the label map itself
std::string label_modes(const std::string& volume, const std::string& field, const Statistics& values, const LabelMap& map);

/// A rail along the flow, and drag, both only where it flows; vortices and tissue where there are any.
/// \param values  statistics of each field of the volume
std::string flow_modes(const Volume& volume, const SceneNames& names, const std::vector<Statistics>& values,
                       const FlowPlaces& flow);

}  // namespace palpa::detail
