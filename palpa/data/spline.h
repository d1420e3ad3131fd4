// Uniform cubic B-spline: its weights, and interpolating coefficients.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>

#include "palpa/data/grid.h"

namespace palpa::detail {

/// β(t+1), β(t), β(1−t), β(2−t) of the cubic B-spline, t in 0…1, and their first and second derivatives.
struct SplineWeights {
  double w[4];  ///< [1]
  double d[4];  ///< [1/voxel]
  double e[4];  ///< [1/voxel²]

  /// Inlined: callers use a part of them.
  [[gnu::always_inline]] explicit SplineWeights(double t) noexcept {
    const double s = 1.0 - t;
    w[0] = s * s * s / 6.0;
    w[1] = 2.0 / 3.0 - t * t * (1.0 - 0.5 * t);
    w[2] = 2.0 / 3.0 - s * s * (1.0 - 0.5 * s);
    w[3] = t * t * t / 6.0;
    d[0] = -0.5 * s * s;
    d[1] = t * (1.5 * t - 2.0);
    d[2] = s * (2.0 - 1.5 * s);
    d[3] = 0.5 * t * t;
    e[0] = s;
    e[1] = 3.0 * t - 2.0;
    e[2] = 3.0 * s - 2.0;
    e[3] = t;
  }
};

/// The 4 × 4 × 4 coefficients about a place in a cell: weights along each axis, and offsets.
struct SplineStencil {
  SplineWeights i, j, k;
  std::int64_t at[3][4];  ///< [voxels] offset from the grid's first voxel, with the strides of memory

  /// \param in_memory  [voxels] along each axis
  /// \param first      [voxels] the cell
  /// \param f          [1] 0…1 across it
  SplineStencil(const std::array<std::int64_t, 3>& dims, const std::array<std::int64_t, 3>& in_memory,
                const std::int64_t (&first)[3], const double (&f)[3]) noexcept
      : i(f[0]), j(f[1]), k(f[2]) {
    std::int64_t stride = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      if (first[a] > 0 && first[a] + 2 < dims[a]) {
        for (std::int64_t n = 0; n < 4; ++n) at[a][n] = (first[a] + n - 1) * stride;
      } else {
        for (std::int64_t n = 0; n < 4; ++n) at[a][n] = std::clamp<std::int64_t>(first[a] + n - 1, 0, dims[a] - 1) * stride;
      }
      stride *= in_memory[a];
    }
  }
  /// Whether the coefficients along i are neighbours: none is repeated beyond the border.
  bool is_inside_row() const noexcept { return at[0][3] - at[0][0] == 3; }
};

/// Coefficients of the spline through `values` at the voxels of `geometry`, with edge coefficients repeated beyond the border
/// as in a smooth grid. Solved along each axis in turn. A non-finite value stays so, and each adjacent run of finite ones is
/// solved separately, its ends as at a border. Uses all cores.
template <class T>
std::shared_ptr<const T> interpolating_coefficients(const GridGeometry& geometry, int components, const T* values);

}  // namespace palpa::detail
