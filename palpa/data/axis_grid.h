// Axis fields: vector grids with arbitrary sign.
#pragma once

#include "palpa/data/grid.h"

namespace palpa {

/// Vector field on an affine grid in which v and −v are equivalent, as the main direction of diffusion in tissue: between
/// voxels of opposite signs a vector would pass through 0. The dyads v vᵀ are interpolated,
/// D = Σ w v vᵀ, with the weights w of a trilinear grid or of a smoothing spline, and the value is
///
///   ±e L g,   L = Σ w |v|,   g = (λ₁ − λ₂)(λ₁ − λ₃)/λ₁²,
///
/// e the unit eigenvector of D to the largest of its eigenvalues λ₁ ≥ λ₂ ≥ λ₃ ≥ 0. g is 1 for voxels equal but for signs, and 0
/// without a preferred direction; for directions in a plane it is the relative gap 1 − λ₂/λ₁; the product of both gaps has no
/// kink at λ₂ = λ₃. `magnitude` of it is L g, a weight of the direction. The sign is arbitrary but a function of the voxels:
/// the largest component is positive.
///
/// The Jacobian is the derivative at fixed sign, exact by the perturbation of the eigenvector; where g is 0, to rounding, value
/// and Jacobian are 0. Negating any voxels changes no bit of a sample (for `offset` = 0). The range of each component is
/// symmetric. Of derived fields, only the magnitude exists.
///
/// `inside` as for `grid_field` (trilinear) or `smooth_grid_field` (smooth). Throws std::invalid_argument, with a sentence,
/// like them, on scalar voxels, and for Filter::cubic: an interpolant of dyads is no dyad between the voxels.
/// `scale` [unit] and `offset` [unit] as for `grid_field`.
FieldPtr axis_grid_field(const GridGeometry& geometry, Voxels voxels, double scale = 1.0, double offset = 0.0,
                         Filter filter = Filter::trilinear);

/// Whether v and −v are equivalent in this field, also a posed one.
bool is_axis_field(const Field& field) noexcept;

}  // namespace palpa
