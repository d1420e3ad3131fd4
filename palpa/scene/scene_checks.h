// What is wrong with a scene and where, for `Scene::check` and for loading, which adds the line.
#pragma once

#include <string>
#include <vector>

#include "palpa/scene/scene.h"

namespace palpa::detail {

/// What part of a scene a finding is about, as far as it is known.
struct Part {
  std::string section;   ///< "coupling", "law", "workspace", "time", "view" or "mode"
  std::size_t mode = 0;  ///< its number
  std::string list;      ///< list parameter of the mode, or "layer" of a view; empty: none
  std::size_t item = 0;
  std::string key;
};

struct Finding {
  Part part;
  std::string text;  ///< what is wrong; what would be right
  bool warning = false;
};

/// "mode 'skin'".
std::string called(const SceneMode& mode);

/// What a mode shows without looking at data: names, ranges, `problem()`.
std::vector<Finding> parameter_findings(const SceneMode& mode, std::size_t number);
/// Whether the fields that a mode names are there and of the right kind.
std::vector<Finding> field_findings(const Scene& scene, const SceneMode& mode, std::size_t number);
/// Whether the fields that are drawn are there and of the right kind: warnings, as they can be felt all the same.
std::vector<Finding> layer_findings(const Scene& scene, const std::vector<ViewLayer>& layers);
/// What is wrong with its time.
std::vector<Finding> time_findings(const Scene& scene);
/// Everything about a scene, warnings included.
std::vector<Finding> findings(const Scene& scene);

/// A warning for each level of a smooth grid at which the filter loses more than a tenth of the thin parts, and with them more
/// than a hundredth of the whole (thin_parts.h); none of volumes whose filter somebody `chose`.
std::vector<Finding> thin_part_findings(const Scene& scene, const std::vector<std::string>& chose);

/// "no volume 'hed'; did you mean 'head'?" for a field's name; empty if its volume is among these.
std::string problem_with_volume_of(const std::string& field, const std::vector<std::string>& volumes);

}  // namespace palpa::detail
