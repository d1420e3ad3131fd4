#include "palpa/scene/mode_inputs.h"

#include <algorithm>

namespace palpa {

ModeInputs resolve(SceneMode& mode, const Scene& scene, std::vector<FieldPtr>& fields) {
  return resolve(mode.mode, mode.masks, [&](const FieldRef& ref, std::optional<Derivation> felt) {
    if (const std::int32_t index = felt ? -1 : scene.index_of(ref); index >= 0) return index;
    const FieldPtr field = felt ? scene.field(ref, *felt) : scene.field(ref).field;
    const auto found = std::find(fields.begin(), fields.end(), field);
    const auto index = static_cast<std::int32_t>(found - fields.begin());
    if (found == fields.end()) fields.push_back(field);
    return index;
  });
}

}  // namespace palpa
