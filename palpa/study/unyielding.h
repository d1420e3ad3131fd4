// Levels that cannot be pressed through.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "palpa/scene/scene.h"

namespace palpa {

/// A level that bears more than what reaches a hand.
struct UnyieldingLevel {
  std::size_t mode = 0;     ///< its number in the scene
  std::string name;         ///< the level's; its value where it has none
  double strength_n = 0.0;  ///< the least it bears
};

/// The levels of all enabled surface modes that bear more than `most_n` [N] everywhere, in the scene's order. Of a strength
/// that is a function of the level's own field its value at the level counts, of another function its smallest value.
/// Allocates; any thread.
std::vector<UnyieldingLevel> unyielding_levels(const Scene& scene, double most_n);

}  // namespace palpa
