// Fields derived from others: magnitudes, components, and what takes derivatives.
#pragma once

#include <optional>
#include <string_view>

#include "palpa/field/field.h"

namespace palpa {

/// What a scene writes as FUNC(FIELD), and `smooth`, `smooth_vector` and `detail`, which modes ask for themselves. u is a
/// velocity with Jacobian J, S and W its symmetric and antisymmetric part, φ a scalar field. Derivatives are per metre of the
/// world.
enum class Derivation : std::uint8_t {
  magnitude,           ///< |u| [unit]
  gradient_magnitude,  ///< |∇φ| [unit/m]
  curl,                ///< ∇×u [unit/m], a vector field
  divergence,          ///< ∇·u [unit/m]
  q,                   ///< (|W|² − |S|²)/2 of the smoothed velocity [unit²/m²]: positive in vortices
  lambda2,             ///< middle eigenvalue of S² + W² of the smoothed velocity [unit²/m²]: negative in vortices
  coherence,           ///< |mean of u| / √(mean of |u|²) around [1]: 1 where vectors agree, near 0 where they are noise
  component_x,         ///< u_x [unit], along the world's x
  component_y,
  component_z,
  smooth,         ///< φ smoothed, for modes whose direction is a gradient
  smooth_vector,  ///< u smoothed, for modes that look at how a flow turns
  detail,         ///< what the voxels say minus what a smoothing filter makes of them [1], −1…1
};

/// The derivation that a scene calls by this name; none for `smooth` and those after it, which have no name there.
std::optional<Derivation> derivation_named(std::string_view name) noexcept;
const char* name_of(Derivation derivation) noexcept;
/// Components of the field that it derives from, and of the field that comes out: 1 or 3.
int components_taken(Derivation derivation) noexcept;
int components_given(Derivation derivation) noexcept;
/// The label of the unit that comes out: of "m/s" a curl is in "1/s" and Q in "1/s²", of "HU" a gradient magnitude
/// in "HU/m", of others it is said as it is, "(cm/s)/m"; empty if unknown.
std::string unit_of(Derivation derivation, std::string_view unit);

/// The derived field.
///
/// `magnitude` and `component_*` are computed where they are asked for, from the source's sample: exact
/// derivatives of its interpolant; where u = 0, the kink of |u|, the gradient is 0. So is `detail`, from the source's voxels.
///
/// All others are computed once, here, at the voxels of the source, and then sampled by the smoothing
/// cubic B-spline (Filter::smooth), value, gradient and Hessian: of a trilinear one the direction would be
/// 25° wrong at p99 on a sampled Lamb–Oseen vortex. Derivatives at a voxel are central differences, the
/// derivative there of Keys' cubic through the voxels, one-sided at the border and beside voxels without
/// a finite value; sampled between, they are smoothed by 1/6, 4/6, 1/6 along each axis.
///
/// `coherence` divides two fields that were smoothed, u and |u|², at the place that is asked for: with smoothing over two
/// spacings noise comes to 0.06, a stream as wide as the smoothing to 0.6. It is 0 where both are.
///
/// `q`, `lambda2`, `coherence`, `smooth` and `smooth_vector` come from data smoothed first by a Gaussian of the world (so many
/// metres along every axis), separable along the axes of the grid, cut off at 4 standard deviations and normalised over the
/// finite voxels within the grid. A voxel without a finite value stays without, and so does what needs it.
///
/// A formula is sampled at its own spacing for all that, 256 times at most along its longest side; a rectilinear grid as
/// often as it has planes, evenly. A posed field is derived below its pose, and the result posed and divided by its scale; only
/// `component_*` are taken above it, as they lie along the world's axes.
///
/// Of a field that changes with time (timed_field.h): below its poses, with the smoothing as it is at the first of them;
/// `magnitude` and `component_*` of its sample at each moment; all others frame by frame, once, here, and then blended like
/// the frames: so many fields more in memory. A formula in time is taken at moments its own time spacing apart.
///
/// \param of           the field; its number of components is `components_taken`
/// \param smoothing_m  [m] standard deviation of that Gaussian in the field's own world; 0: two sample spacings
/// As many threads as there are cores; memory beyond the result's own is what the Gaussian reaches of slices, as floats, for
/// each of them. Throws std::invalid_argument, with a sentence, on a field of the other kind, on axes (`signless`) for all but
/// the magnitude, or a smoothing that is negative or not finite.
FieldPtr derived(Derivation derivation, const FieldPtr& of, double smoothing_m = 0.0);

}  // namespace palpa
