// Levels that cannot be pressed through.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "palpa/scene/scene.h"

namespace palpa {

/// Level stronger than the largest force at the hand.
struct UnyieldingLevel {
  std::size_t mode = 0;     ///< number in the scene
  std::string name;         ///< of the level; its value if unnamed
  double strength_n = 0.0;  ///< least strength
};

/// Levels of all enabled surface modes stronger than `most_n` [N] everywhere, in the scene's order. A strength as a function of
/// the level's own field counts by its value at the level, of another field by its smallest value. Allocates; any thread.
std::vector<UnyieldingLevel> unyielding_levels(const Scene& scene, double most_n);

}  // namespace palpa
