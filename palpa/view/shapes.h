// Solid shapes in the hand frame: tubes, arrows. Those of a moment are palpa/vtk/felt_actors.h.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "palpa/solver/vec3.h"
#include "palpa/view/colors.h"

class vtkRenderer;

namespace palpa::detail {

/// [1] Share of a surface's colour that comes without light; the rest is such that a patch that faces the viewer has its own
/// colour, as in legends and colour bars. More: shapes look flat; less: what turns away is black.
inline constexpr double surface_ambient = 0.25;
void add_light(vtkRenderer* renderer);

/// [1] What the lamps of add_light do at a point: the factors of its own colour, and of that in which it shines.
struct Light {
  double diffuse = 0.0;
  double specular = 0.0;
};
/// As VTK lights a pixel. \param normal  [1] unit vector, x right, y up, z to the viewer; of the side away from the viewer:
/// turned over \param shininess  [1] more: smaller highlights
Light light_on(const Vec3& normal, double shininess) noexcept;

struct TubePoint {
  Vec3 position_m;
  Color color;
};

/// One tube through each line's points, coloured along it; lines of one point are left out. `shine` [1]: how
/// much of the colour comes without light, so that it can be read off a colour bar.
void draw_tubes(vtkRenderer* renderer, std::span<const std::vector<TubePoint>> lines, double radius_m, double shine = 0.45);
struct Arrow {
  Vec3 from_m;
  Vec3 to_m;
  Color color;
};
/// Many arrows at once, each as thick as it is long allows.
void draw_arrows(vtkRenderer* renderer, std::span<const Arrow> arrows);

}  // namespace palpa::detail
