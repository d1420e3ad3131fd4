// Derived fields: magnitudes, components, derivatives and smoothed fields.
#pragma once

#include <optional>
#include <string_view>

#include "palpa/data/field.h"

namespace palpa {

/// Derivations: FUNC(FIELD) in scenes, and `smooth`, `smooth_vector` and `detail`, which modes request. u is a velocity with
/// Jacobian J, S and W its symmetric and antisymmetric part, φ a scalar field. Derivatives are per metre of the world.
enum class Derivation : std::uint8_t {
  magnitude,           ///< |u| [unit]
  gradient_magnitude,  ///< |∇φ| [unit/m]
  curl,                ///< ∇×u [unit/m], a vector field
  divergence,          ///< ∇·u [unit/m]
  q,                   ///< (|W|² − |S|²)/2 of the smoothed velocity [unit²/m²]: positive in vortices
  lambda2,             ///< middle eigenvalue of S² + W² of the smoothed velocity [unit²/m²]: negative in vortices
  coherence,           ///< |mean of u| / √(mean of |u|²) around [1]: 1 for equal vectors, near 0 for noise
  component_x,         ///< u_x [unit], along the world's x
  component_y,
  component_z,
  smooth,         ///< φ smoothed, for modes with a gradient as direction
  smooth_vector,  ///< u smoothed, for modes of a flow's rotation
  detail,         ///< voxels minus their smoothed interpolant [1], scaled to −1…1
};

/// Derivation by its name in scenes; none for other names: `smooth` and later ones have no name there.
std::optional<Derivation> derivation_named(std::string_view name) noexcept;
const char* name_of(Derivation derivation) noexcept;
/// Components of the source and of the resulting field: 1 or 3.
int components_taken(Derivation derivation) noexcept;
int components_given(Derivation derivation) noexcept;
/// Unit of the result for a field in `unit`: from "m/s" a curl has "1/s" and Q "1/s²", from "HU" a gradient magnitude has
/// "HU/m"; other units are combined without simplification, "(cm/s)/m"; empty if `unit` is.
std::string unit_of(Derivation derivation, std::string_view unit);

/// Derived field.
///
/// `magnitude` and `component_*` are computed for each sample, from the source's sample, with exact derivatives of its
/// interpolant; at u = 0, the kink of |u|, the gradient is 0. `detail` is computed for each sample, from the source's voxels.
///
/// All others are computed once, by this function, at the voxels of the source, and then sampled by the smoothing cubic
/// B-spline (Filter::smooth), value, gradient and Hessian: with trilinear sampling the direction error would be 25° at p99 on a
/// sampled Lamb–Oseen vortex. Derivatives at a voxel are central differences, the derivative there of Keys' cubic through the
/// voxels, one-sided at the border and beside voxels without a finite value; between voxels, they are smoothed by 1/6, 4/6, 1/6
/// along each axis.
///
/// `coherence` divides two smoothed fields, u and |u|², at the sample: with smoothing over two spacings noise has 0.06, a
/// stream as wide as the smoothing 0.6. It is 0 where both are 0.
///
/// `q`, `lambda2`, `coherence`, `smooth` and `smooth_vector` use data smoothed by a Gaussian, isotropic in the world, separable
/// along the axes of the grid, cut off at 4 standard deviations and normalised over the finite voxels within the grid. A voxel
/// without a finite value stays without, and so do values computed from it.
///
/// For these a formula is sampled at its own spacing, at most 256 times along its longest side, and a rectilinear grid evenly,
/// at as many samples as planes. A posed field is derived below its pose; the result is posed and, if a derivative, divided by
/// the scale. Only `component_*` are computed above the pose: they are along the world's axes.
///
/// A field that changes with time (timed_field.h) is derived below its poses, with the smoothing for the first of them;
/// `magnitude` and `component_*` from its sample at each moment; all others per frame, and then blended like the frames, at the
/// memory of as many more frames. A formula in time is derived at moments its time spacing apart.
///
/// \param of           the field, of `components_taken` components
/// \param smoothing_m  [m] standard deviation of that Gaussian in the field's own world; 0: two sample spacings
/// Uses all cores; each thread needs memory for the slices within the Gaussian's support, as floats. Throws
/// std::invalid_argument, with a sentence, on a field of the wrong kind, on axis fields (`signless`) for all but the magnitude,
/// on a negative or infinite smoothing, on a formula in time of so many moments that it would take minutes (limits.h:
/// derived_samples), and on insufficient free memory.
FieldPtr derived(Derivation derivation, const FieldPtr& of, double smoothing_m = 0.0);

}  // namespace palpa
