// The layers of a scene: surfaces, slices, volumes, streamlines and glyphs of its fields.
#pragma once

#include <vector>

#include "palpa/scene/scene.h"
#include "palpa/time/timed_field.h"
#include "palpa/view/canvas.h"

class vtkRenderer;

namespace palpa::detail {

/// The scene's layers; where it names none, what its modes feel: levels as surfaces, other scalar fields as
/// slices, vector fields as streamlines.
std::vector<ViewLayer> layers_of(const Scene& scene);

/// The field in the hand frame: positions and vectors turned, values as they are.
FieldPtr in_hand_frame(const FieldPtr& field, const Similarity& hand_to_world);

/// What a drawn layer has to be explained with.
struct LayerSigns {
  std::vector<LegendEntry> legend;
  std::vector<ColorBar> bars;
};

/// What a layer of surface looks like.
struct SurfaceStyle {
  double level;  ///< the field's own unit
  Color color;
  double opacity;  ///< [1] face on
};
/// That of layer `number`, which is a surface. \param see_through  something inside is to be seen
SurfaceStyle surface_style(const Scene& scene, const std::vector<ViewLayer>& layers, std::size_t number, bool see_through);

struct LayerOptions {
  Box near;          ///< hand frame: what is farther is not drawn
  bool see_through;  ///< something inside is to be seen: surfaces let it through
  DataTime at;       ///< data that change are drawn as they are then
  double unit_m;     ///< half the picture's height
  Vec3 towards;      ///< [1] to the viewer, hand frame: edges of what is translucent are denser
};

/// Draws the layers in the hand frame: what is opaque with `solid`; what is translucent with `shells`, which draws after
/// it and keeps its depths. Throws SceneError on a field that is not there, LoadError on one that cannot be drawn so.
LayerSigns draw_layers(vtkRenderer* solid, vtkRenderer* shells, const Scene& scene, const std::vector<ViewLayer>& layers,
                       const LayerOptions& options);

}  // namespace palpa::detail
