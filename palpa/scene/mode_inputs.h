// Inputs of a mode of a scene.
#pragma once

#include <vector>

#include "palpa/mode/inputs.h"
#include "palpa/scene/scene.h"

namespace palpa {

/// Resolves a mode's references to field numbers: the fields of the scene's volumes, which are in `fields`, then their
/// derivations, appended without duplicates. Allocates; throws SceneError if a field is missing.
ModeInputs resolve(SceneMode& mode, const Scene& scene, std::vector<FieldPtr>& fields);

}  // namespace palpa
