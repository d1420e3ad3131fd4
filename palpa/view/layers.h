// The layers of a scene: surfaces, slices, volumes, streamlines and glyphs of its fields.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "palpa/data/timed_field.h"
#include "palpa/scene/scene.h"
#include "palpa/view/canvas.h"

class vtkActor;
class vtkPolyData;
class vtkRenderer;

namespace palpa::detail {

/// The scene's layers. A scene without any shows what its modes read: levels as surfaces, other scalar fields as slices, vector
/// fields as streamlines.
std::vector<ViewLayer> layers_of(const Scene& scene);

/// The field in the hand frame: positions and vectors turned, values as they are.
FieldPtr in_hand_frame(const FieldPtr& field, const Similarity& hand_to_world);

/// From the values of a layer's field, or their magnitudes, to its colours: as the layer says, else those for what it shows.
ColorMap colors_of(const ViewLayer& layer, const Field& field);

/// A translucent surface as it was drawn, to be shaded again for another viewer. What draws it keeps it alive.
struct Shell {
  vtkPolyData* surface;
  Color color;
  double opacity;  ///< [1] face on
};
/// Colours the points of a translucent surface: denser where it turns away, as glass is. \param towards  [1] to the viewer
void shade(const Shell& shell, const Vec3& towards);

/// What a layer of surface looks like.
struct SurfaceStyle {
  double level;  ///< the field's own unit
  Color color;
  double opacity;  ///< [1] face on
};

/// An actor of a layer. The renderer keeps it alive.
struct LayerActor {
  vtkActor* actor;
  std::size_t layer;                  ///< number in the scene's layers
  std::optional<SurfaceStyle> style;  ///< of a surface
  std::string words;                  ///< of a surface, as in the legend
  std::optional<std::size_t> bar;     ///< number in `bars` of what explains its colours
};

/// What explains the drawn layers beside the picture.
struct LayerSigns {
  std::vector<LegendEntry> legend;
  std::vector<ColorBar> bars;
  std::vector<Shell> shells;
  std::vector<LayerActor> actors;
};

/// The look of layer `number`, which is a surface. \param see_through  something inside has to be seen through it
SurfaceStyle surface_style(const Scene& scene, const std::vector<ViewLayer>& layers, std::size_t number, bool see_through);

struct LayerOptions {
  Box near;          ///< hand frame: what is farther is not drawn
  bool see_through;  ///< something inside has to be seen: outer surfaces are translucent
  DataTime at;       ///< the moment at which data that change are drawn
  double unit_m;     ///< half the picture's height
  Vec3 towards;      ///< [1] to the viewer, hand frame: edges of what is translucent are denser
};

/// Draws the layers in the hand frame: what is opaque with `solid`; what is translucent with `shells`, which has to draw after
/// `solid` and keep its depths. Throws LoadError on a field that is unknown or of the wrong kind.
LayerSigns draw_layers(vtkRenderer* solid, vtkRenderer* shells, const Scene& scene, const std::vector<ViewLayer>& layers,
                       const LayerOptions& options);

}  // namespace palpa::detail
