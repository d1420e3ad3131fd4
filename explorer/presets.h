// Presets for kinds of data: common colours, opacities and windows.
#pragma once

#include <span>
#include <string>

#include "palpa/scene/scene.h"

namespace palpa::explorer {

/// Display preset. Values are HU for CT, else shares [1] of the data's range.
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

/// Layers and window for a scene: its first field of the preset's kind replaces the previous layers. Throws SceneError if there
/// is no such field.
struct Preseted {
  std::vector<ViewLayer> layers;
  double window_low = 0.0, window_high = 1.0;  ///< the field's own unit
};
Preseted apply(const Preset& preset, const Scene& scene);

}  // namespace palpa::explorer
