// Surfaces of layers: where a field has a value, as VTK draws it.
#pragma once

#include "palpa/view/layers.h"

class vtkImageData;
template <class T>
class vtkSmartPointer;

namespace palpa::detail {

/// The surface of `image` at `level`, without triangles that touch places without data. All triangles are turned to the side
/// that is outside for most of them.
/// \param level  the field's own unit
vtkSmartPointer<vtkPolyData> surface_of(vtkImageData* image, const Field& field, double level);

/// The surface without parts that are small beside the largest: in scans these are tables, rests and specks.
vtkSmartPointer<vtkPolyData> large_parts(vtkPolyData* surface);

/// Opaque, lit actor of a surface.
vtkSmartPointer<vtkActor> actor_of(vtkPolyData* surface, const Color& color);

/// [1] Opacity of a translucent surface where the line of sight grazes it; face on it is the layer's. More: rims hide what is
/// inside; less: the shape is hard to see.
inline constexpr double rim_opacity = 0.85;

/// The part of a translucent surface that is nearest to the viewer. \param towards  [1] to the viewer
void draw_shell(vtkRenderer* renderer, const Shell& shell, const Vec3& towards);

}  // namespace palpa::detail
