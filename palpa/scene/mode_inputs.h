// What a mode of a scene reads.
#pragma once

#include <vector>

#include "palpa/mode/inputs.h"
#include "palpa/scene/scene.h"

namespace palpa {

/// Gives a mode's references the numbers of their fields: those of the scene's volumes, which are in `fields`, then what is
/// derived from them, once each, appended. Allocates; throws SceneError where a field is missing.
ModeInputs resolve(SceneMode& mode, const Scene& scene, std::vector<FieldPtr>& fields);

}  // namespace palpa
