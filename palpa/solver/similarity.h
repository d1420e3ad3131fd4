// Map between the hand frame and the world of the data.
#pragma once

#include "palpa/solver/vec3.h"

namespace palpa {

/// Similarity: rotation, uniform scale, translation. As a workspace it maps hand metres to world metres; as a pose it moves a
/// volume in the world.
///
/// Forces are computed in hand metres: a mode's positions, directions and derivatives are in the hand frame, and no force
/// depends on the size of the data in the world. Scaling the data and this map by a common factor changes no force; by a power
/// of two, not even a bit.
struct Similarity {
  Mat3 rotation = Mat3::identity();  ///< proper rotation (determinant +1)
  double scale = 1.0;                ///< [1] world metres per hand metre; > 0
  Vec3 translation_m{};              ///< [m] world position of the hand frame's origin

  friend bool operator==(const Similarity&, const Similarity&) = default;

  /// World position [m] of a hand position [m].
  constexpr Vec3 to_world(const Vec3& hand_m) const noexcept { return rotation * (scale * hand_m) + translation_m; }
  /// Hand position [m] of a world position [m].
  constexpr Vec3 to_hand(const Vec3& world_m) const noexcept {
    return transposed_times(rotation, world_m - translation_m) / scale;
  }
  /// `world`, a vector in the world in its own unit (a velocity, a normal), rotated into the hand frame.
  constexpr Vec3 direction_to_hand(const Vec3& world) const noexcept { return transposed_times(rotation, world); }
  /// `hand`, a vector of the hand frame in its own unit, rotated into the world.
  constexpr Vec3 turned_to_world(const Vec3& hand) const noexcept { return rotation * hand; }
  /// Gradient per hand metre of a field with the gradient `per_world_metre` [unit/m]: s·Rᵀ g.
  constexpr Vec3 gradient_to_hand(const Vec3& per_world_metre) const noexcept {
    return scale * transposed_times(rotation, per_world_metre);
  }
  /// Jacobian per hand metre of the rotated field from the Jacobian per world metre: s·Rᵀ J R.
  constexpr Mat3 jacobian_to_hand(const Mat3& per_world_metre) const noexcept {
    return scale * (transposed(rotation) * per_world_metre * rotation);
  }
  /// A world length [m] as a hand length [m].
  constexpr double length_to_hand(double world_m) const noexcept { return world_m / scale; }
};

/// Whether the map is valid: finite, scale > 0, rotation orthonormal to 1e-9 and not a mirror.
bool is_usable(const Similarity& map) noexcept;

/// Right-handed rotation about an axis. Multiples of 90° about x, y and z are exact: values of a rotated volume keep their
/// bits. Any thread.
/// \param axis     [1] of any length above 0
/// \param turn_deg  [°] finite
Mat3 rotation_about(const Vec3& axis, double turn_deg) noexcept;
/// Axis and angle of a rotation.
struct AxisTurn {
  Vec3 axis{0, 0, 1};     ///< [1] of length 1
  double turn_deg = 0.0;  ///< 0…180
};
/// Inverse of `rotation_about`, to rounding; the z axis for no rotation. Any thread.
AxisTurn axis_angle(const Mat3& rotation) noexcept;

}  // namespace palpa
