// The laws of earlier systems, to compare with. Nothing in the tick needs them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "palpa/scene/scene.h"
#include "palpa/solver/law.h"

namespace palpa::baseline {

/// The names of all laws, the exact one first: those that a scene file takes for `[law] method` (a test compares the two
/// lists).
std::vector<std::string> law_names();

/// The law that a scene names in `[law] method`, which may be the exact one, to solve single balances by. A session gets it
/// through `baseline::path`. Allocates; throws SceneError on an unknown name.
std::unique_ptr<Law> law(const Scene& scene);

}  // namespace palpa::baseline
