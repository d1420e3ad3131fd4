// Map of a workspace from the hand frame to the world. Internal.
#pragma once

#include <vector>

#include "palpa/scene/scene.h"

namespace palpa::detail {

/// Hand to world, for these volumes. Throws SceneProblem.
Similarity workspace_map(const Workspace& workspace, const std::vector<SceneVolume>& volumes);

}  // namespace palpa::detail
