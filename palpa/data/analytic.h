// Embedded data: analytic fields with exact derivatives.
//
// A formula has data in its box only, faces included. Its spacing is the size of its finest feature over a whole number: steps
// of half a spacing follow the feature closely. A volume has one field unless stated. Functions with sizes throw
// std::invalid_argument, with a sentence, unless they are finite and positive.
#pragma once

#include <span>
#include <string_view>

#include "palpa/data/field.h"
#include "palpa/data/volume.h"

namespace palpa {

/// Half space: value = signed distance [m] below the plane z = 0 of the world (positive is solid), over a cube of side `size_m`
/// about the origin. Field "depth" [m]; spacing size / 64.
Volume plane_field(double size_m = 0.2);

/// Ball: value = radius − |x| [m], positive inside (solid), over a cube of side 3 radii about the origin; the gradient at the
/// centre is 0. Field "depth" [m]; spacing radius / 32.
Volume sphere_field(double radius_m = 0.05);

/// Half space below z = 0 with a round hole along −z, its rim rounded: value = signed distance [m] below the surface, exact,
/// positive in the solid. About the origin, 8 radii wide, from 2 radii below the hole's floor to as far above the surface as
/// the hole is deep. Field "depth" [m]; spacing the smaller of radius / 16 and rim / 4.
/// \param radius_m  [m] of the hole
/// \param depth_m   [m] of the hole
/// \param rim_m     [m] radius of the rounding, at most the depth, else std::invalid_argument
Volume bored_block(double radius_m = 5.5e-3, double depth_m = 30e-3, double rim_m = 1.5e-3);

/// CT phantom of a head, in HU, in the medical frame: skin and soft tissue (about 40), skull (1000), brain (35), air cavities
/// (nose, sinuses, throat: −1000), air outside (−1000). Edges are smooth ramps about 2 mm wide: the gradient is continuous.
/// About 160 × 200 × 240 mm about the origin, in a box that cuts the neck; face at −y; 6 to 8 mm of skin on the skull. Field
/// "ct" [HU]; spacing 1 mm, half an edge.
Volume head_phantom();

/// Lamb–Oseen vortex along z: u_t = Γ/(2πr) (1 − exp(−r²/r_c²)), over a cube of side 12 r_c about the origin. Field "velocity"
/// [m/s]; spacing r_c / 8.
/// \param circulation_m2_per_s  [m²/s] Γ
/// \param core_radius_m         [m] r_c, > 0
Volume lamb_oseen_vortex(double circulation_m2_per_s = 0.02, double core_radius_m = 0.01);

/// Burgers vortex along z: the Lamb–Oseen profile with r_c = √(4ν/a), kept steady by the strain u_r = −a r/2, u_z = a z. Box,
/// field and spacing as above.
/// \param circulation_m2_per_s  [m²/s] Γ
/// \param core_radius_m         [m] r_c, > 0
/// \param strain_per_s          [1/s] a, >= 0
Volume burgers_vortex(double circulation_m2_per_s = 0.02, double core_radius_m = 0.01, double strain_per_s = 0.2);

/// Pulsing vortex ring in a closed chamber, as in a filling ventricle: velocity u = ∇×(f (−y, x, 0)) with
///
///   f = c exp(−((ρ² − R²)/(2Rb))² − ((z − z₀)/b)²) (1 − e)³,  ρ² = x² + y²,  e = (x² + y²)/a² + z²/h²,
///
/// a ring of radius R = 14 mm and core b = 8 mm about the z axis, its jet along +z, in an ellipsoid of semi-axes a = 27 mm and
/// h = 32 mm: exactly free of divergence, and zero with its Jacobian at the wall e = 1 and beyond. The field's shape is ours; a
/// Gaussian stream function about a circle is the usual model of a ring with a thick core (P. G. Saffman, "Vortex Dynamics",
/// 1992, §10). Fields "velocity" [m/s], at most 0.6 m/s, and "signal" [a.u.], a magnitude image: 1 in the blood, 0 outside, an
/// edge of 2 mm at the wall. Box 60 × 60 × 70 mm, spacing 1 mm.
///
/// Steady, at one moment of the heartbeat; `beating_chamber` plays it. Over a beat the ring's strength is 0.6 + 0.4 sin(2π
/// beat), its position z₀ = −6 mm cos(2π beat).
/// \param beat  [1] moment of the heartbeat, of period 1; 0.25 is the strongest. Finite.
Volume ring_vortex(double beat = 0.25);

/// `ring_vortex` with a beating heart: a beat of 0.8 s, repeated when looped. The wall and its content move as x = S X, S =
/// diag(s, s, 1/s²), s = exp(0.06 sin(2π beat)): it widens while it shortens, at constant volume; the wall moves at up to 35
/// mm/s. Fields, exact at any moment, with derivatives:
///
///   signal(x) = signal₀(S⁻¹x),  velocity(x) = Ṡ S⁻¹ x + S u₀(S⁻¹x; beat),
///
/// signal₀ and u₀ from `ring_vortex` at that moment: exactly free of divergence; at the wall the blood moves with it. "signal"
/// is carried with the wall, x → S(to) S(from)⁻¹ x. Box 64 × 64 × 80 mm, spacing 1 mm, time spacing 40 ms.
Volume beating_chamber();

/// Wake of a wing: free stream U = 1 m/s along +x and a horseshoe of straight vortices of circulation Γ = 0.4 m²/s, x
/// downstream, y along the span, z up: bound from y = −1.4 m to 1.4 m at the quarter chord x = 0.25 m (span 3, chord 1), and
/// counter-rotating tip vortices from its ends to x = ∞. Each by Biot and Savart with the distance regularised as √(r² + ε²), ε
/// = 0.12 m (L. Rosenhead, Proc. R. Soc. A 127, 1930): the curl of a vector potential, so exactly free of divergence, and
/// finite. Fields "velocity" [m/s], and "pressure" [m²/s²], kinematic:
///
///   p = −U u'_x − ½ Σ ω² (r² + ε²),
///
/// u' the velocity minus the free stream (linearised Bernoulli: suction above the wing), and over the three vortices, r from
/// the line, ω the rotation rate [1/s] of that vortex: for a straight infinite line exactly the pressure that holds the swirl
/// on its circles, lowest in the core; interaction of the vortices is neglected. Box 3.5 × 3.8 × 1.2 m, spacing 0.03 m.
Volume wing_wake();

/// Embedded data, named by `analytic = "…"` in scenes.
struct AnalyticVolume {
  std::string_view name;
  std::string_view sentence;
  Volume (*make)();
};
std::span<const AnalyticVolume> analytic_volumes() noexcept;
/// Embedded data that change with time, named likewise.
std::span<const AnalyticVolume> beating_volumes() noexcept;
/// Embedded data by name, from both lists; nullptr if unknown.
const AnalyticVolume* analytic_volume(std::string_view name) noexcept;

}  // namespace palpa
