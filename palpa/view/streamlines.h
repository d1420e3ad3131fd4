// Streamlines of any vector field, evenly apart.
#pragma once

#include <vector>

#include "palpa/data/field.h"

namespace palpa::detail {

struct StreamPoint {
  Vec3 position_m;
  double speed;  ///< the field's own unit
};
using Streamline = std::vector<StreamPoint>;

/// At most `most` streamlines within `box`, both ways from seeds on a regular grid; none starts near another. At most half of
/// them begin in vortices, where the flow turns while it crosses the box, the strongest first; these lie closer together, so
/// that they wind about a core. The others begin where the field is fastest. Integrated by a Runge-Kutta method of fourth order
/// along the direction of the field, in steps of about half its spacing. The same field gives the same lines.
std::vector<Streamline> streamlines(const Field& field, const Box& box, std::size_t most);

/// The part that two boxes share; of no size where they share none.
Box shared_part(const Box& a, const Box& b) noexcept;

/// Positions of a regular grid over the box, its cells' middles, `longest` along the longest side.
std::vector<Vec3> grid_positions(const Box& box, int longest);

}  // namespace palpa::detail
