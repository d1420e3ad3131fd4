// Layers of a scene prepared for a window, on any thread: fine for a still picture, coarse for a moving one.
#pragma once

#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <cstddef>
#include <optional>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/scene/scene.h"
#include "palpa/view/layers.h"

class vtkProp;
class vtkVolume;

namespace palpa::explorer {

/// Simplified surface, lit per vertex instead of per pixel: a third less processor time.
struct CoarseSurface {
  vtkSmartPointer<vtkPolyData> surface;       ///< scalars: vertex colours in the current light
  vtkSmartPointer<vtkUnsignedCharArray> own;  ///< unlit RGBA of the vertices; a shell's depend on the viewer
  std::optional<detail::Shell> shell;         ///< of `surface`
  vtkSmartPointer<vtkProperty> look;          ///< of the fine surface

  /// Computes the vertex colours for a viewer. \param right, up, towards  [1] unit vectors of the view; `towards`: to the
  /// viewer
  void light(const Vec3& right, const Vec3& up, const Vec3& towards);
};

/// Rendered layers of a scene, hand frame.
struct Drawing {
  struct Part {
    vtkSmartPointer<vtkProp> fine;
    vtkSmartPointer<vtkProp> coarse;  ///< shown while the picture moves; null: `fine` is
    std::size_t layer = 0;            ///< index in the scene's layers
  };
  std::vector<Part> solid, shells;
  std::vector<vtkSmartPointer<vtkVolume>> clouds;  ///< of `solid`; their sampling is changed
  std::vector<detail::Shell> fine_shells;
  std::vector<CoarseSurface> coarse_surfaces;
  detail::LayerSigns signs;
  Box bounds_m{};                     ///< of the data, hand frame
  std::vector<Vec3> stream_points_m;  ///< on drawn streamlines, hand frame
  bool is_rough = false;              ///< a finer drawing follows
  std::size_t fine_triangles = 0, coarse_triangles = 0;
};

/// Draws all layers except slices (the window draws these itself). Throws LoadError.
/// \param towards  [1] to the viewer, hand frame
/// \param rough    a preview with few samples, in a small part of the time
Drawing draw_for_window(const Scene& scene, const Vec3& towards, bool rough);

}  // namespace palpa::explorer
