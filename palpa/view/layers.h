// Layers of a scene: surfaces, slices, volumes, streamlines and glyphs of its fields.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/data/timed_field.h"
#include "palpa/scene/scene.h"
#include "palpa/view/canvas.h"

class vtkActor;
class vtkPolyData;
class vtkRenderer;

namespace palpa::detail {

/// The scene's layers; by default the fields of its modes: levels as surfaces, other scalar fields as slices, vector fields as
/// streamlines.
std::vector<ViewLayer> layers_of(const Scene& scene);

/// Field in the hand frame: positions and vectors rotated, values unchanged.
FieldPtr in_hand_frame(const FieldPtr& field, const Similarity& hand_to_world);

/// Colours of a layer's field (its values or magnitudes): the layer's own, else the default of its kind.
ColorMap colors_of(const ViewLayer& layer, const Field& field);

/// Translucent surface, reshaded for each viewer. Its actor owns `surface`.
struct Shell {
  vtkPolyData* surface;
  Color color;
  double opacity;  ///< [1] face on
};
/// Computes point opacities: higher where the surface turns away, like glass. \param towards  [1] to the viewer
void shade(const Shell& shell, const Vec3& towards);

/// Style of a surface layer.
struct SurfaceStyle {
  double level;  ///< the field's own unit
  Color color;
  double opacity;  ///< [1] face on
};

/// Actor of a layer, owned by the renderer.
struct LayerActor {
  vtkActor* actor;
  std::size_t layer;                  ///< index in the scene's layers
  std::optional<SurfaceStyle> style;  ///< of a surface
  std::string words;                  ///< of a surface, as in the legend
  std::optional<std::size_t> bar;     ///< index in `bars` of its colour bar
};

/// Legend and colour bars of the drawn layers, and their actors.
struct LayerSigns {
  std::vector<LegendEntry> legend;
  std::vector<ColorBar> bars;
  std::vector<Shell> shells;
  std::vector<LayerActor> actors;
};

/// Style of layer `number`, a surface. \param see_through  contents must stay visible
SurfaceStyle surface_style(const Scene& scene, const std::vector<ViewLayer>& layers, std::size_t number, bool see_through);

struct LayerOptions {
  Box near;          ///< hand frame: the rest is cut off
  bool see_through;  ///< contents must stay visible: outer surfaces are translucent
  DataTime at;       ///< time of the data
  double unit_m;     ///< half the picture's height
  Vec3 towards;      ///< [1] to the viewer, hand frame, for the edges of translucent surfaces
  /// [1] Samples along the longest side of a surface's or cloud's field. More: time and memory, cubed; fewer: details are lost.
  int most_samples = 160;
  int most_lines = 64;  ///< [1] streamlines of a layer
};

/// Vector field as it is drawn, without positions where the masks of the first mode that reads it are nearly zero: noise is no
/// flow. \param field  hand frame, of `ref`
FieldPtr drawn_flow(const Scene& scene, const FieldRef& ref, const FieldPtr& field, DataTime at);

/// Whether a name of a field says no more than its kind, as readers and programs give them: "value", "scalars", "vectors".
bool is_generic_name(std::string_view name);

/// Name of layer `number` in the legend, with its value or unit: "skin", "speed / m/s". Allocates. Throws SceneError on an
/// unknown field.
std::string layer_words(const Scene& scene, const std::vector<ViewLayer>& layers, std::size_t number);

/// Draws the layers in the hand frame: opaque with `solid`, translucent with `shells`, which has to draw after `solid` and keep
/// its depth buffer. Throws LoadError on a field that is unknown or of the wrong kind.
LayerSigns draw_layers(vtkRenderer* solid, vtkRenderer* shells, const Scene& scene, const std::vector<ViewLayer>& layers,
                       const LayerOptions& options);

}  // namespace palpa::detail
