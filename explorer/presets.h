// Looks for kinds of data: colours, opacities and windows that people know from their own programs.
#pragma once

#include <span>
#include <string>

#include "palpa/scene/scene.h"

namespace palpa::explorer {

/// A look. Its values are those of a CT [HU], or shares [1] of the range of the values of any other data.
struct Preset {
  struct Point {
    double value;
    const char* color;
    double opacity;
  };
  const char* name;
  enum class For { ct, scalar, vector } for_data;
  ViewLayer::Show show;
  std::span<const Point> points;   ///< of clouds and colour maps
  double window_low, window_high;  ///< of slices
};
std::span<const Preset> presets();

/// What a preset makes of a scene: its first field of the right kind is shown so, in place of the layers before. Throws
/// SceneError where there is no such field.
struct Preseted {
  std::vector<ViewLayer> layers;
  double window_low = 0.0, window_high = 1.0;  ///< the field's own unit
};
Preseted apply(const Preset& preset, const Scene& scene);

}  // namespace palpa::explorer
