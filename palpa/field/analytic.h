// Embedded data: fields that are formulas and know their own derivatives.
//
// A formula has data only in its box, faces included. Its spacing is the size of its finest feature over
// a whole number, so that a path of half a spacing per step follows the feature closely. Each volume has
// one field. Functions with sizes throw std::invalid_argument, with a sentence, on sizes that are no
// finite, positive numbers.
#pragma once

#include <span>
#include <string_view>

#include "palpa/field/field.h"

namespace palpa {

/// A half space: value = signed distance [m] below the plane z = 0 of the world (positive is solid),
/// over a cube of side `size_m` about the origin. Field "depth" [m]; spacing size / 64.
Volume plane_field(double size_m = 0.2);

/// A ball: value = radius − |x| [m], positive inside (solid), over a cube of side 3 radii about the
/// origin; its gradient at the very centre is 0. Field "depth" [m]; spacing radius / 32.
Volume sphere_field(double radius_m = 0.05);

/// A head as CT would see it, in HU, in the medical frame: skin and soft tissue (about 40), skull
/// (1000), brain (35), air cavities (nose, sinuses, throat: −1000), air outside (−1000). Edges are smooth
/// ramps about 2 mm wide, so the gradient is defined and continuous everywhere. About 160 × 200 × 240 mm
/// about the origin, in a box that cuts the neck; the face is at −y, 6 to 8 mm of skin lie on the skull.
/// Field "ct" [HU]; spacing 1 mm, half an edge.
Volume head_phantom();

/// A Lamb–Oseen vortex along z: u_t = Γ/(2πr) (1 − exp(−r²/r_c²)), over a cube of side 12 r_c about the
/// origin. Field "velocity" [m/s]; spacing r_c / 8.
/// \param circulation_m2_per_s  [m²/s] Γ
/// \param core_radius_m         [m] r_c, > 0
Volume lamb_oseen_vortex(double circulation_m2_per_s = 0.02, double core_radius_m = 0.01);

/// A Burgers vortex along z: the Lamb–Oseen profile with r_c = √(4ν/a), held steady by the strain
/// u_r = −a r/2, u_z = a z. Box, field and spacing as above.
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
