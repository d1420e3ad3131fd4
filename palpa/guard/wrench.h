// Force and torque on the hand.
#pragma once

#include "palpa/solver/pose.h"

namespace palpa {

/// Force on the hand, and torque about the device's point.
struct Wrench {
  Vec3 force_n;
  Vec3 torque_nm;

  friend constexpr bool operator==(const Wrench&, const Wrench&) = default;
};

constexpr Wrench operator+(const Wrench& a, const Wrench& b) noexcept {
  return {a.force_n + b.force_n, a.torque_nm + b.torque_nm};
}
constexpr Wrench operator-(const Wrench& a, const Wrench& b) noexcept {
  return {a.force_n - b.force_n, a.torque_nm - b.torque_nm};
}
/// \param f  [1]
constexpr Wrench operator*(double f, const Wrench& a) noexcept { return {f * a.force_n, f * a.torque_nm}; }
inline bool is_finite(const Wrench& a) noexcept { return is_finite(a.force_n) && is_finite(a.torque_nm); }

/// Size [N] of force and torque together, the torque divided by the turning radius of the tool; without a torque that of the
/// force to the bit.
/// \param turning_radius_m  [m] > 0
inline double size_n(const Wrench& a, double turning_radius_m) noexcept {
  return a.torque_nm == Vec3{} ? norm(a.force_n) : std::hypot(norm(a.force_n), norm(a.torque_nm) / turning_radius_m);
}

/// `a`, shortened to the size `largest_n` >= 0 [N] if it is larger.
inline Wrench shortened(const Wrench& a, double largest_n, double turning_radius_m) noexcept {
  const double all_n = size_n(a, turning_radius_m);
  return all_n > largest_n ? (largest_n / all_n) * a : a;
}

}  // namespace palpa
