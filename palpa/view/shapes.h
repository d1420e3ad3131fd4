// Solid shapes in the hand frame: tubes, arrows. Shapes of a moment: palpa/vtk/felt_actors.h.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "palpa/solver/vec3.h"
#include "palpa/view/colors.h"

class vtkRenderer;

namespace palpa::detail {

/// [1] Ambient share of a surface's colour; with the rest a patch that faces the viewer has exactly its own colour, as in
/// legends and colour bars. More: flat shapes; less: surfaces that turn away are black.
inline constexpr double surface_ambient = 0.25;
void add_light(vtkRenderer* renderer);

/// [1] Light of add_light's lamps at a point: factors of the diffuse and the specular colour.
struct Light {
  double diffuse = 0.0;
  double specular = 0.0;
};
/// VTK's shading of a pixel. \param normal  [1] unit vector, x right, y up, z to the viewer; flipped if it points away \param
/// shininess  [1] more: smaller highlights
Light light_on(const Vec3& normal, double shininess) noexcept;

struct TubePoint {
  Vec3 position_m;
  Color color;
};

/// One tube along each line, coloured by its points; lines of one point are left out. `shine` [1]: ambient share of the colour,
/// so that it can be read off a colour bar.
void draw_tubes(vtkRenderer* renderer, std::span<const std::vector<TubePoint>> lines, double radius_m, double shine = 0.45);
struct Arrow {
  Vec3 from_m;
  Vec3 to_m;
  Color color;
};
/// Many arrows at once, thickness limited by length.
void draw_arrows(vtkRenderer* renderer, std::span<const Arrow> arrows);

}  // namespace palpa::detail
