// Embedded data: fields that are formulas and know their own derivatives.
#pragma once

#include <span>
#include <string_view>

#include "palpa/field/field.h"

namespace palpa {

/// A half space: value = signed distance [m] below the plane z = 0 of the world (positive is solid),
/// over a box of `size_m`.
Volume plane_field(double size_m = 0.2);

/// A ball: value = radius − |x| [m], positive inside (solid), over a box of 3 radii.
Volume sphere_field(double radius_m = 0.05);

/// A head as CT would see it, in HU, in the medical frame: skin and soft tissue (about 40), skull
/// (about 1000), brain (35), air cavities (nose, sinuses: −1000), air outside (−1000). Edges are smooth
/// ramps about 2 mm wide, so the gradient is defined everywhere. About 160 × 200 × 240 mm.
Volume head_phantom();

/// A Lamb–Oseen vortex along z: u_t = Γ/(2πr) (1 − exp(−r²/r_c²)).
/// \param circulation_m2_per_s  [m²/s] Γ
/// \param core_radius_m         [m] r_c, > 0
Volume lamb_oseen_vortex(double circulation_m2_per_s = 0.02, double core_radius_m = 0.01);

/// A Burgers vortex along z: the Lamb–Oseen profile with r_c = √(4ν/a), held steady by the strain
/// u_r = −a r/2, u_z = a z.
/// \param circulation_m2_per_s  [m²/s] Γ
/// \param core_radius_m         [m] r_c, > 0
/// \param strain_per_s          [1/s] a, >= 0
Volume burgers_vortex(double circulation_m2_per_s = 0.02, double core_radius_m = 0.01, double strain_per_s = 0.2);

/// The embedded data that a scene can name with `analytic = "…"`.
struct AnalyticVolume {
  std::string_view name;
  std::string_view sentence;
  Volume (*make)();
};
std::span<const AnalyticVolume> analytic_volumes() noexcept;

}  // namespace palpa
