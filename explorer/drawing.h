// The layers of a scene made ready for a window, on any thread: fine for a still picture, coarse for one that moves.
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

/// A surface of fewer triangles, lit at its points, not at its pixels, which costs a processor a third less.
struct CoarseSurface {
  vtkSmartPointer<vtkPolyData> surface;       ///< its scalars: the points' colours in this light
  vtkSmartPointer<vtkUnsignedCharArray> own;  ///< RGBA of its points without light; those of a shell change with the viewer
  std::optional<detail::Shell> shell;         ///< of `surface`
  vtkSmartPointer<vtkProperty> look;          ///< of the fine surface

  /// Lights it for a viewer. \param right, up, towards  [1] unit vectors of the view; `towards`: to the viewer
  void light(const Vec3& right, const Vec3& up, const Vec3& towards);
};

/// What a window shows of the layers of a scene, in the hand frame.
struct Drawing {
  struct Part {
    vtkSmartPointer<vtkProp> fine;
    vtkSmartPointer<vtkProp> coarse;  ///< in its place while the picture moves; null: the same
  };
  std::vector<Part> solid, shells;
  std::vector<vtkSmartPointer<vtkVolume>> clouds;  ///< of `solid`, to be drawn finer and coarser
  std::vector<detail::Shell> fine_shells;
  std::vector<CoarseSurface> coarse_surfaces;
  detail::LayerSigns signs;
  Box bounds_m{};  ///< of the data, hand frame
  std::size_t fine_triangles = 0, coarse_triangles = 0;
};

/// Draws all layers but slices, which the window draws itself. Throws LoadError.
/// \param towards  [1] to the viewer, hand frame
Drawing draw_for_window(const Scene& scene, const Vec3& towards);

}  // namespace palpa::explorer
