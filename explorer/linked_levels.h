// One level, felt and seen: surface layers follow the levels of modes, and these follow the layers.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "palpa/scene/scene.h"

namespace palpa::explorer {

/// A level that a mode feels.
struct FeltLevel {
  std::string mode, field;
  std::string name;     ///< empty: none
  std::size_t row = 0;  ///< of the mode's parameters
  double value = 0.0;   ///< the field's own unit
  bool enabled = true;  ///< of the mode
};
/// All levels of all modes, in the scene's order. Allocates.
std::vector<FeltLevel> felt_levels(const Scene& scene);

/// Felt level next to the value of a layer; none if the layer is no surface or no mode feels levels of its field. Equal values:
/// the link is whole. \param layer  with its level
std::optional<FeltLevel> level_of(const Scene& scene, const ViewLayer& layer);

/// Completes a change of a scene: where felt level and surface layer had one value, both get the changed one.
/// \param loose  indices of layers that do not follow
void link_levels(const Scene& before, Scene& after, const std::set<std::size_t>& loose);

}  // namespace palpa::explorer
