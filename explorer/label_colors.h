// Label maps in slices: a colour and a name for each number.
#pragma once

#include <string>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/scene/scene.h"
#include "palpa/view/colors.h"

namespace palpa::explorer {

/// Label of a map, as the scene names it.
struct SeenLabel {
  double value = 0.0;  ///< in the field's own unit
  std::string name;
  detail::Color color;  ///< of its surface in the 3-D view, if it has one
};

/// Labels of the volume of which `name` is the map, in the scene's order; empty for other fields. Allocates.
std::vector<SeenLabel> labels_of(const Scene& scene, const std::string& name);
/// Name of the scene's first label map, the field that its labels are parts of; empty: none.
std::string name_of_label_map(const Scene& scene);
/// Label of a value; null for the background and for labels without a name.
const SeenLabel* label_at(const std::vector<SeenLabel>& labels, double value);
/// Value of the nearest voxel, since between two labels there is no third: world frame. The field itself without voxels.
FieldPtr nearest_voxels(const FieldPtr& field);

}  // namespace palpa::explorer
