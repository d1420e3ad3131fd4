// Rigid poses: turns as unit quaternions, and motions between poses in metres.
#pragma once

#include "palpa/solver/vec3.h"

namespace palpa {

/// Rotation as a unit quaternion w + xi + yj + zk [1]. The default is no rotation.
struct Turn {
  double w = 1.0;
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  friend constexpr bool operator==(const Turn&, const Turn&) = default;
};

/// Rotation by `b`, then by `a`.
constexpr Turn operator*(const Turn& a, const Turn& b) noexcept {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
constexpr Turn inverse(const Turn& turn) noexcept { return {turn.w, -turn.x, -turn.y, -turn.z}; }

/// `v`, in any unit, rotated by the unit quaternion `turn`.
constexpr Vec3 rotated(const Turn& turn, const Vec3& v) noexcept {
  const Vec3 axis{turn.x, turn.y, turn.z};
  const Vec3 twice = 2.0 * cross(axis, v);
  return v + turn.w * twice + cross(axis, twice);
}

/// Whether the length of the quaternion is 1 to within `tolerance` [1]; false for values that are not finite.
inline bool is_unit(const Turn& turn, double tolerance) noexcept {
  return std::abs(std::sqrt(turn.w * turn.w + turn.x * turn.x + turn.y * turn.y + turn.z * turn.z) - 1.0) <= tolerance;
}

/// The quaternion divided by its length, which must not be zero.
inline Turn unit_turn(const Turn& turn) noexcept {
  const double by_length = 1.0 / std::sqrt(turn.w * turn.w + turn.x * turn.x + turn.y * turn.y + turn.z * turn.z);
  return {by_length * turn.w, by_length * turn.x, by_length * turn.y, by_length * turn.z};
}

/// Rotation about `rotation_rad` by its length [rad] (exponential map).
inline Turn turn_by(const Vec3& rotation_rad) noexcept {
  const double angle_rad = norm(rotation_rad);
  // sin(a/2)/a; below 1e-4 rad the next term is beneath rounding.
  const double share = angle_rad < 1e-4 ? 0.5 - angle_rad * angle_rad / 48.0 : std::sin(0.5 * angle_rad) / angle_rad;
  return {std::cos(0.5 * angle_rad), share * rotation_rad.x, share * rotation_rad.y, share * rotation_rad.z};
}

/// Rotation vector [rad] of the unit quaternion `turn`, of length 0…π (logarithm).
inline Vec3 rotation_rad(const Turn& turn) noexcept {
  const Vec3 axis{turn.x, turn.y, turn.z};
  const double sine = norm(axis);
  if (sine == 0.0) return {};
  const double w = std::abs(turn.w);
  const double half_rad = std::atan2(sine, w);
  // Below 1e-4 the ratio is 1/w times a series whose next term is beneath rounding.
  const double share = sine < 1e-4 ? (1.0 - sine * sine / (3.0 * w * w)) / w : half_rad / sine;
  return (turn.w < 0.0 ? -2.0 : 2.0) * share * axis;
}

/// Rotation vector [rad] that turns `from` into `to`, about axes of the space in which both are given; zero to the bit for
/// equal turns.
inline Vec3 rotation_between_rad(const Turn& from, const Turn& to) noexcept {
  return from == to ? Vec3{} : rotation_rad(to * inverse(from));
}

/// `turn`, rotated further about `rotation_rad` [rad], of unit length to rounding; for no rotation `turn` to the bit.
inline Turn turned_further(const Turn& turn, const Vec3& rotation_rad) noexcept {
  return rotation_rad == Vec3{} ? turn : unit_turn(turn_by(rotation_rad) * turn);
}

/// Rotation matrix of the unit quaternion `turn`.
constexpr Mat3 matrix_of(const Turn& turn) noexcept {
  return transposed({{rotated(turn, {1, 0, 0}), rotated(turn, {0, 1, 0}), rotated(turn, {0, 0, 1})}});
}

/// Position and orientation of a rigid body.
struct Pose {
  Vec3 position_m;
  Turn turn;

  friend constexpr bool operator==(const Pose&, const Pose&) = default;
};

/// Motion of a rigid body between two poses. An arc is a rotation vector times the turning radius of a tool, so that way and
/// arc are lengths in one Euclidean metric (docs/theory.md 10.1). The arc of a point is zero.
struct Motion {
  Vec3 way_m;
  Vec3 arc_m;

  friend constexpr bool operator==(const Motion&, const Motion&) = default;
  constexpr Motion& operator+=(const Motion& b) noexcept { return way_m += b.way_m, arc_m += b.arc_m, *this; }
  constexpr Motion& operator-=(const Motion& b) noexcept { return way_m -= b.way_m, arc_m -= b.arc_m, *this; }
};

constexpr Motion operator+(const Motion& a, const Motion& b) noexcept { return {a.way_m + b.way_m, a.arc_m + b.arc_m}; }
constexpr Motion operator-(const Motion& a, const Motion& b) noexcept { return {a.way_m - b.way_m, a.arc_m - b.arc_m}; }
constexpr Motion operator*(double f, const Motion& a) noexcept { return {f * a.way_m, f * a.arc_m}; }
constexpr Motion operator/(const Motion& a, double f) noexcept { return {a.way_m / f, a.arc_m / f}; }
constexpr double dot(const Motion& a, const Motion& b) noexcept { return dot(a.way_m, b.way_m) + dot(a.arc_m, b.arc_m); }
constexpr double length_squared(const Motion& a) noexcept { return norm_squared(a.way_m) + norm_squared(a.arc_m); }
inline bool is_finite(const Motion& a) noexcept { return is_finite(a.way_m) && is_finite(a.arc_m); }

/// Length [m] in the metric of way and arc; of a motion without arc the length of the way to the bit.
inline double length(const Motion& a) noexcept {
  return a.arc_m == Vec3{} ? norm(a.way_m) : std::hypot(norm(a.way_m), norm(a.arc_m));
}

/// `a`, shortened to the length `longest` >= 0 [m] if it is longer.
inline Motion shortened(const Motion& a, double longest) noexcept {
  const double all = length(a);
  return all > longest ? (longest / all) * a : a;
}

}  // namespace palpa
