// Findings about a scene and their parts; loading adds the line.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "palpa/base/wording.h"
#include "palpa/scene/scene.h"

namespace palpa::detail {

/// Part of a scene that a finding is about.
struct Part {
  std::string section;   ///< "coupling", "law", "workspace", "time", "tool", "view", "hand" or "mode"
  std::size_t mode = 0;  ///< number of the mode or hand
  std::string list;      ///< list parameter of the mode, "layer" of a view, or "tool" of a hand; empty: none
  std::size_t item = 0;
  std::string key;
};

struct Finding {
  Part part;
  std::string text;  ///< fault; remedy
};

/// SceneError of a finding; loading adds the line.
struct SceneProblem : SceneError {
  explicit SceneProblem(Finding of)
      : SceneError(one_line((of.part.section == "workspace" ? "workspace: " : "scene: ") + of.text)), finding(std::move(of)) {}
  Finding finding;
};
/// Throws SceneProblem at the first finding.
void refuse_first(const std::vector<Finding>& found);

/// "mode 'skin'".
std::string called(const SceneMode& mode);
/// "hand 'left'".
std::string called(const SceneHand& hand);
std::vector<std::string> names_of(const std::vector<SceneHand>& hands);

// Faults, each checked once: by the functions of Scene that take a part.

/// Values out of range.
std::vector<Finding> range_findings(CouplingOptions coupling);
std::vector<Finding> range_findings(Workspace workspace);
std::vector<Finding> range_findings(TimeOptions time);
/// Also keys that do not fit the shape.
std::vector<Finding> range_findings(ToolOptions tool);
/// A hand among the others: its name, its place, its tool.
std::vector<Finding> hand_findings(const Scene& scene, const SceneHand& hand, std::size_t number);
/// Unknown name of a law.
std::vector<Finding> law_findings(const std::string& name);
/// Name, ranges, `problem()` of a mode, without its data.
std::vector<Finding> parameter_findings(const SceneMode& mode, std::size_t number);
/// A mode among others: its name is taken, or its fields do not exist or are of the wrong kind.
std::vector<Finding> mode_findings(const Scene& scene, const SceneMode& mode, std::size_t number);

// Warnings: the scene can be felt anyway.

/// Existence and kind of drawn fields.
std::vector<Finding> layer_findings(const Scene& scene, const std::vector<ViewLayer>& layers);
/// Of time, levels and textures.
std::vector<Finding> warnings(const Scene& scene);

/// Findings of levels of smooth grids, by the origin of the filter.
struct ThinPartFindings {
  std::vector<Finding> by_default, by_choice;
};
/// Finds each level of a smooth grid at which the filter loses more than a tenth of the thin parts, and with them more than a
/// hundredth of the whole (thin_parts.h). \param chose  volumes whose filter the scene names
ThinPartFindings thin_part_findings(const Scene& scene, const std::vector<std::string>& chose);

/// "no volume 'hed'; did you mean 'head'?" for a field's name; empty if its volume is among these.
std::string problem_with_volume_of(const std::string& field, const std::vector<std::string>& volumes);

}  // namespace palpa::detail
