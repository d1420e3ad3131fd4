#include "explorer/presets.h"

#include <array>
#include <cmath>

namespace palpa::explorer {
namespace {

using Point = Preset::Point;
using Show = ViewLayer::Show;

constexpr std::array bone{Point{-1000, "#000000", 0.0}, Point{180, "#6b3e2e", 0.0}, Point{320, "#c9a27a", 0.6},
                          Point{900, "#f4ead8", 0.97}, Point{2500, "#ffffff", 0.99}};
constexpr std::array skin{Point{-1000, "#000000", 0.0}, Point{-500, "#8a5a44", 0.0}, Point{-250, "#d9a384", 0.85},
                          Point{60, "#e8c3a9", 0.95},   Point{300, "#f4ead8", 0.8},  Point{2500, "#ffffff", 0.95}};
constexpr std::array brain{Point{-1000, "#000000", 0.0}, Point{0, "#3a3a55", 0.0},   Point{25, "#8f8fb0", 0.1},
                           Point{45, "#d8c7c0", 0.3},    Point{80, "#ffe9d0", 0.35}, Point{120, "#ffffff", 0.0},
                           Point{2500, "#ffffff", 0.0}};
constexpr std::array lung{Point{-1000, "#000000", 0.0}, Point{-950, "#1b2a4a", 0.0}, Point{-800, "#3f78a8", 0.08},
                          Point{-550, "#bfd7e6", 0.25}, Point{-300, "#f2e6d8", 0.0}, Point{2500, "#ffffff", 0.0}};
constexpr std::array resonance{Point{0.0, "#000000", 0.0}, Point{0.12, "#1d1d1d", 0.0}, Point{0.35, "#7d7468", 0.15},
                               Point{0.7, "#e5ddd0", 0.5}, Point{1.0, "#ffffff", 0.8}};
constexpr std::array angiogram{Point{0.0, "#000000", 0.0}, Point{0.3, "#3b0a08", 0.0}, Point{0.45, "#a6261b", 0.35},
                               Point{0.75, "#f08a5d", 0.7}, Point{1.0, "#ffe9c9", 0.9}};
// Matplotlib's viridis and a blue-red map with a light middle (Moreland, Diverging color maps for scientific visualization,
// 2009).
constexpr std::array viridis{Point{0.0, "#440154", 0.0}, Point{0.25, "#3b528b", 0.03}, Point{0.5, "#21918c", 0.1},
                             Point{0.75, "#5ec962", 0.3}, Point{1.0, "#fde725", 0.7}};
constexpr std::array diverging{Point{0.0, "#3b4cc0", 0.7}, Point{0.25, "#8db0fe", 0.2}, Point{0.5, "#dddddd", 0.0},
                               Point{0.75, "#f49a7b", 0.2}, Point{1.0, "#b40426", 0.7}};

constexpr std::array all{
    Preset{"CT: bone", Preset::For::ct, Show::volume, bone, -500, 1300},
    Preset{"CT: skin", Preset::For::ct, Show::volume, skin, -160, 240},
    Preset{"CT: brain", Preset::For::ct, Show::volume, brain, 0, 80},
    Preset{"CT: lung", Preset::For::ct, Show::volume, lung, -1350, 150},
    Preset{"MR", Preset::For::scalar, Show::volume, resonance, 0.0, 0.9},
    Preset{"Angiogram", Preset::For::scalar, Show::volume, angiogram, 0.1, 1.0},
    Preset{"Perceptual (viridis)", Preset::For::scalar, Show::volume, viridis, 0.0, 1.0},
    Preset{"Diverging", Preset::For::scalar, Show::volume, diverging, 0.0, 1.0},
    Preset{"Flow: streamlines", Preset::For::vector, Show::streamlines, {}, 0.0, 1.0},
    Preset{"Flow: arrows", Preset::For::vector, Show::glyphs, {}, 0.0, 1.0},
};

}  // namespace

std::span<const Preset> presets() { return all; }

Preseted apply(const Preset& preset, const Scene& scene) {
  const int components = preset.for_data == Preset::For::vector ? 3 : 1;
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) {
      if (field.field->components() != components) continue;
      const std::string name = volume.volume.fields.size() == 1 ? volume.name : volume.name + "." + field.name;
      double low = 0.0, high = 0.0;
      for (const ValueRange& extent : field.field->value_ranges()) {
        if (components == 1) low = extent.min;
        high = components == 1 ? extent.max : std::hypot(high, std::max(std::abs(extent.min), std::abs(extent.max)));
      }
      const bool shares = preset.for_data != Preset::For::ct;
      const auto value = [&](double v) { return shares ? low + v * (high - low) : v; };
      Preseted made{.layers = {{.show = preset.show, .field = {name}}},
                    .window_low = value(preset.window_low),
                    .window_high = value(preset.window_high)};
      for (const Point& point : preset.points)
        made.layers.front().colors.push_back({value(point.value), point.color, point.opacity});
      return made;
    }
  }
  throw SceneError(std::string("preset '") + preset.name + "': the scene has no " + (components == 3 ? "vector" : "scalar") +
                   " field; choose a preset for " + (components == 3 ? "scalar data" : "flows"));
}

}  // namespace palpa::explorer
