// Affine grids sampled by cubic B-splines.
#pragma once

#include "palpa/data/grid.h"

namespace palpa {

/// Field on an affine grid with the voxels as coefficients of a uniform cubic B-spline: value = raw · scale + offset of Σ c_ijk
/// β(x−i) β(y−j) β(z−k), twice continuously differentiable, with value, gradient and Hessian of that one function. Without a
/// prefilter it smooths instead of interpolating: at a voxel it gives 1/6, 4/6, 1/6 of the voxels along each axis, which adds
/// h²/6 ∂²φ/∂x² there; 8-bit steps are not amplified, and the gradient's direction is more accurate than a trilinear field's
/// (M. Unser, "Splines: a perfect fit", IEEE Signal Proc. Mag. 16(6), 1999). Its price: a level of curvatures κ₁, κ₂ moves
/// inwards by h²(κ₁ + κ₂)/6, and parts thinner than two voxels fade.
///
/// `inside` as for `grid_field`. Beyond the borders the edge coefficients repeat. A place is outside if one of the 4 × 4 × 4
/// coefficients about its cell is not finite, or a value overflows a double. An axis of one voxel has no extent: the field is
/// constant across it.
///
/// 1 or 3 components of any type. `scale` [unit] and `offset` [unit] as for `grid_field`; throws like it.
FieldPtr smooth_grid_field(const GridGeometry& geometry, Voxels voxels, double scale = 1.0, double offset = 0.0);

/// Interpolating cubic B-spline, with value, gradient and Hessian of that one function: its coefficients are computed here,
/// once, in the voxels' own type and beside the voxels, on all cores. At every voxel within data it gives the voxel, to the
/// rounding of that type; away from borders, where its slope along the axis is 0, cubics are reproduced. `inside` as above.
/// Only for voxels of a floating-point type: with whole numbers it would amplify the steps (the direction of the gradient is 4
/// to 5° wrong at p99 on 8 bits, 1.5° with the smoothing spline), so it throws std::invalid_argument, with a sentence, as it
/// does where `grid_field` does.
/// `scale` [unit] and `offset` [unit] likewise.
FieldPtr cubic_grid_field(const GridGeometry& geometry, Voxels voxels, double scale = 1.0, double offset = 0.0);

/// Grid behind a field made by `smooth_grid_field`; nullptr for other fields.
const GridView* smooth_grid_of(const Field& field) noexcept;

}  // namespace palpa
