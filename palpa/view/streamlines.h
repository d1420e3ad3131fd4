// Evenly spaced streamlines of any vector field.
#pragma once

#include <vector>

#include "palpa/data/field.h"

namespace palpa::detail {

struct StreamPoint {
  Vec3 position_m;
  double speed;  ///< the field's own unit
};
using Streamline = std::vector<StreamPoint>;

/// At most `most` streamlines within `box`, both ways from seeds on a regular grid, none starting near another. At most half of
/// them start in vortices, where the flow rotates while it crosses the box, the strongest first, with smaller distances, so
/// that they wind about a core; the others start where the field is fastest. Fourth-order Runge-Kutta along the direction of
/// the field, in steps of about half its spacing. Deterministic.
std::vector<Streamline> streamlines(const Field& field, const Box& box, std::size_t most);

/// Intersection of two boxes; of zero size if they are disjoint.
Box shared_part(const Box& a, const Box& b) noexcept;

/// Cell centres of a regular grid over the box, `longest` along its longest side.
std::vector<Vec3> grid_positions(const Box& box, int longest);

}  // namespace palpa::detail
