// The laws of earlier systems, to compare with. Nothing in the tick needs them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "palpa/core/law.h"
#include "palpa/scene/scene.h"

namespace palpa::baseline {

/// The names of all laws, the exact one first: those that a scene file takes for `[law] method`, and a test compares the two.
std::vector<std::string> law_names();

/// The law that a scene names in `[law] method`, the exact one included, to pose it balances. A session takes it by
/// `baseline::path`. Allocates; throws SceneError on a name that is none.
std::unique_ptr<Law> law(const Scene& scene);

}  // namespace palpa::baseline
