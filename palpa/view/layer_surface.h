// Isosurfaces of layers, for VTK.
#pragma once

#include "palpa/view/layers.h"

class vtkImageData;
template <class T>
class vtkSmartPointer;

namespace palpa::detail {

/// Isosurface of `image` at `level`, without triangles that touch positions without data. All face the side that is outside for
/// most of them.
/// \param level  the field's own unit
vtkSmartPointer<vtkPolyData> surface_of(vtkImageData* image, const Field& field, double level);

/// Surface without small components: in scans these are tables, remains and specks.
vtkSmartPointer<vtkPolyData> large_parts(vtkPolyData* surface);

/// Opaque, lit actor of a surface.
vtkSmartPointer<vtkActor> actor_of(vtkPolyData* surface, const Color& color);

/// [1] Opacity of a translucent surface at grazing view; face on it is the layer's. More: rims hide the interior; less: the
/// shape is hard to see.
inline constexpr double rim_opacity = 0.85;

/// Draws the nearest part of a translucent surface. \param towards  [1] to the viewer
void draw_shell(vtkRenderer* renderer, const Shell& shell, const Vec3& towards);

}  // namespace palpa::detail
