// Surfaces in fewer triangles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa::detail {

/// Triangulated surface.
struct Mesh {
  std::vector<Vec3> points_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of points
};

/// Surface of fewer triangles, whose points are all used.
struct SimplerMesh : Mesh {
  std::vector<std::uint32_t> like;  ///< for each point a near one of the original surface
};

/// Surface with about `most_triangles`, or all if there are no more: edges are collapsed, each to the position with the least
/// sum of squared distances to the planes of the triangles that it stands for (Garland and Heckbert 1997), the least first. No
/// triangle turns by more than 78° at once, and no edge gets more triangles. Allocates; any thread.
SimplerMesh simplified(const Mesh& surface, std::size_t most_triangles);

}  // namespace palpa::detail
