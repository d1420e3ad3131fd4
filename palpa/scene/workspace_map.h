// Map of a workspace from the hand frame to the world. Internal.
#pragma once

#include <string>
#include <vector>

#include "palpa/scene/scene.h"

namespace palpa::detail {

/// Thrown for a workspace that cannot be.
struct WorkspaceProblem {
  std::string key;
  std::string text;
};

/// Hand to world, for these volumes. Throws WorkspaceProblem.
Similarity workspace_map(const Workspace& workspace, const std::vector<SceneVolume>& volumes);

}  // namespace palpa::detail
