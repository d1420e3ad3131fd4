// Mode tables of a first scene, and layers that show them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "palpa/data/labels.h"
#include "palpa/data/statistics.h"
#include "palpa/scene/first_flow.h"
#include "palpa/scene/first_levels.h"
#include "palpa/scene/first_volume_table.h"

namespace palpa::detail {

/// A scalar field as surfaces, with drag within the solid.
/// \param faint  start of the drag: for a sparse object the median of its box; else the first level
std::string surface_modes(const std::string& field, const Statistics& values, const FirstLevels& first, double faint);

/// Names of a map's labels: as given for their values, as different plain words; else by the values.
/// \param taken  names of other fields of the volume
std::vector<std::string> label_names(const LabelMap& map, const std::vector<std::pair<std::string, double>>& given,
                                     const std::vector<std::string>& taken);
/// Key of the volume that makes a field of each of the largest labels. \param names  of `map.labels`
std::string labels_line(const LabelMap& map, const std::vector<std::string>& names);
/// A surface for each of the largest labels, with drag within all labels. \param field  the label map itself
std::string label_modes(const std::string& volume, const std::string& field, const Statistics& values, const LabelMap& map,
                        const std::vector<std::string>& names);

/// A rail along the flow, and drag, both only within the flow; vortices and tissue if there are any.
/// \param values  statistics of each field of the volume
std::string flow_modes(const Volume& volume, const SceneNames& names, const std::vector<Statistics>& values,
                       const FlowPlaces& flow);

}  // namespace palpa::detail
