// Shared parts of the tests of derived fields: grids of functions on skewed voxels.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "palpa/data/derived.h"
#include "tests/data/test_fields.h"

namespace palpa::test::derived_grids {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

inline constexpr Derivation all[] = {Derivation::magnitude,   Derivation::gradient_magnitude,
                                     Derivation::curl,        Derivation::divergence,
                                     Derivation::q,           Derivation::lambda2,
                                     Derivation::component_x, Derivation::component_y,
                                     Derivation::component_z, Derivation::smooth};

/// Grids of a function of the world position, in double.
inline FieldPtr scalars(const GridGeometry& g, const std::function<double(const Vec3&)>& value) {
  std::vector<double> values;
  for (std::int64_t k = 0; k < g.dims[2]; ++k)
    for (std::int64_t j = 0; j < g.dims[1]; ++j)
      for (std::int64_t i = 0; i < g.dims[0]; ++i) values.push_back(value(g.to_world({double(i), double(j), double(k)})));
  return grid_field(g, voxels_of(std::move(values)));
}
inline FieldPtr vectors(const GridGeometry& g, const std::function<Vec3(const Vec3&)>& value) {
  std::vector<double> values;
  for (std::int64_t k = 0; k < g.dims[2]; ++k)
    for (std::int64_t j = 0; j < g.dims[1]; ++j)
      for (std::int64_t i = 0; i < g.dims[0]; ++i) {
        const Vec3 v = value(g.to_world({double(i), double(j), double(k)}));
        values.insert(values.end(), {v.x, v.y, v.z});
      }
  return grid_field(g, voxels_of(std::move(values), 3));
}

inline const Mat3 skew_steps{{{0.011, 0.002, -0.001}, {-0.003, 0.009, 0.002}, {0.001, 0.001, -0.014}}};
inline const GridGeometry small{{9, 8, 7}, skew_steps, {0.3, -0.2, 0.1}};
/// Wide enough to keep the border outside of a Gaussian of 2 spacings at the middle.
inline const GridGeometry wide{{41, 41, 41}, skew_steps, {0.3, -0.2, 0.1}};

inline Vec3 random_world(std::mt19937& random, const GridGeometry& g, double margin) {
  return g.to_world({uniform(random, margin, double(g.dims[0] - 1) - margin),
                     uniform(random, margin, double(g.dims[1] - 1) - margin),
                     uniform(random, margin, double(g.dims[2] - 1) - margin)});
}

}  // namespace palpa::test::derived_grids
