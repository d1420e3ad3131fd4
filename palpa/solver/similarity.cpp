#include "palpa/solver/similarity.h"

#include <cmath>
#include <numbers>

namespace palpa {

bool is_usable(const Similarity& map) noexcept {
  if (!std::isfinite(map.scale) || !(map.scale > 0.0) || !is_finite(map.translation_m) || !is_finite(map.rotation))
    return false;
  const Mat3 gram = map.rotation * transposed(map.rotation);
  const Mat3 one = Mat3::identity();
  for (int i = 0; i < 3; ++i) {
    if (largest_component(gram.row[i] - one.row[i]) > 1e-9) return false;
  }
  return determinant(map.rotation) > 0.0;
}

Mat3 rotation_about(const Vec3& axis, double turn_deg) noexcept {
  const double reduced = std::fmod(turn_deg, 360.0);
  const double quarters = reduced / 90.0;
  double sine = std::sin(reduced * std::numbers::pi / 180.0);
  double cosine = std::cos(reduced * std::numbers::pi / 180.0);
  if (quarters == std::round(quarters)) {
    sine = std::round(sine);
    cosine = std::round(cosine);
  }
  const Vec3 a = normalized(axis);
  const double v = 1.0 - cosine;
  return {{{a.x * a.x * v + cosine, a.x * a.y * v - a.z * sine, a.x * a.z * v + a.y * sine},
           {a.y * a.x * v + a.z * sine, a.y * a.y * v + cosine, a.y * a.z * v - a.x * sine},
           {a.z * a.x * v - a.y * sine, a.z * a.y * v + a.x * sine, a.z * a.z * v + cosine}}};
}

// R = c + (1 − c) a aᵀ + s [a]×.
AxisTurn axis_angle(const Mat3& r) noexcept {
  const Vec3 twice_sine{r.row[2].y - r.row[1].z, r.row[0].z - r.row[2].x, r.row[1].x - r.row[0].y};
  const double cosine = 0.5 * (r.row[0].x + r.row[1].y + r.row[2].z - 1.0);
  const double turn_deg = std::atan2(0.5 * norm(twice_sine), cosine) * 180.0 / std::numbers::pi;
  Vec3 axis = normalized(twice_sine);
  if (cosine < 0.0) {
    // Towards a half turn the sine vanishes; the longest row of (R + Rᵀ)/2 − c = (1 − c) a aᵀ lies along the axis.
    Vec3 longest;
    for (int i = 0; i < 3; ++i) {
      const Vec3 row = 0.5 * (r.row[i] + transposed(r).row[i]) - cosine * Mat3::identity().row[i];
      if (norm(row) > norm(longest)) longest = row;
    }
    axis = dot(longest, twice_sine) < 0.0 ? normalized(-longest) : normalized(longest);
  }
  if (axis == Vec3{}) axis = {0, 0, 1};
  return {axis, turn_deg};
}

}  // namespace palpa
