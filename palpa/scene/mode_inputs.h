// What a mode of a scene reads.
#pragma once

#include <cstdint>
#include <vector>

#include "palpa/mode/crossings.h"
#include "palpa/scene/scene.h"

namespace palpa {

/// The fields that a mode reads, by number, and where in their values it may set in.
struct ModeInputs {
  std::vector<std::int32_t> fields;        ///< once each
  std::int32_t main_field = -1;            ///< its parameter `field`
  std::vector<Watch> watches;              ///< its levels, and the points of its strengths and masks
  std::vector<const Strength*> strengths;  ///< those of the mode that are functions; it outlives this
  bool onset_is_watched = false;           ///< where it places nothing, only a watch can make it place something
};

/// Gives a mode's references the numbers of their fields: those of the scene's volumes, which are in `fields`, then what is
/// derived from them, once each, appended. Allocates; throws SceneError where a field is missing.
ModeInputs resolve(SceneMode& mode, const Scene& scene, std::vector<FieldPtr>& fields);

}  // namespace palpa
