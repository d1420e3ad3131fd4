// Data of the path tests and benchmarks: closed-form solids, and fields from formulas.
#pragma once

#include <functional>
#include <ostream>
#include <vector>

#include "palpa/data/grid.h"
#include "palpa/data/quantile.h"
#include "palpa/data/volume.h"
#include "palpa/scene/scene.h"
#include "tests/path/bumpy_sphere.h"

namespace palpa::test {

/// Depth [m] of a position in a solid: above 0 inside, the distance to its surface near there.
using Depth = std::function<double(const Vec3& x_m)>;

/// Voxels of a solid's depth as a scanner stores them: `bits` of resolution from −ramp to +ramp voxels, flat beyond; ramp 0:
/// binary, half a voxel apart from the level.
struct Sampling {
  int bits = 12;
  double ramp_voxels = 3.0;
};
/// The depth [m] of a solid on a grid; its surface is level 0.
FieldPtr sampled_depth(const Depth& depth, const GridGeometry& geometry, const Sampling& sampling, Filter filter);
/// A grid's voxels as floats under that filter: a smoothing filter would not keep integers.
FieldPtr in_floats(const Field& grid, Filter filter);

/// A cube of `voxels` samples along each side, `voxel_m` [m] apart, about the origin, turned by `turn`.
GridGeometry cube_of(int voxels, double voxel_m, const Mat3& turn = Mat3::identity());

/// A scalar field from a formula of value and gradient, over a cube of side `size_m` [m] about the origin.
FieldPtr formula(std::function<ScalarSample(const Vec3&)> at, double size_m, double spacing_m);
/// A vector field from a formula of value and Jacobian.
FieldPtr vector_formula(std::function<VectorSample(const Vec3&)> at, double size_m, double spacing_m);

Volume volume_of(FieldPtr field, const char* unit = "m");
/// A grid's own filter, which overrides the default of its voxels.
std::optional<Filter> filter_of(const Field& field);

/// One hand metre is one world metre, origins and axes together.
Workspace plain_workspace();
Scene plain_scene(const CouplingOptions& coupling);

/// A V-groove along z with its bottom at the origin, open towards +y by `opening_rad` [rad].
Depth groove(double opening_rad);

using detail::quantile;

}  // namespace palpa::test
