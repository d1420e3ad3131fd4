// Vectors and 3×3 matrices: all linear algebra of the tick. Allocates nothing, never throws.
#pragma once

#include <algorithm>
#include <cmath>

namespace palpa {

/// Vector of three doubles, in the unit of its variable's name.
struct Vec3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
  constexpr Vec3& operator+=(const Vec3& b) noexcept { return x += b.x, y += b.y, z += b.z, *this; }
  constexpr Vec3& operator-=(const Vec3& b) noexcept { return x -= b.x, y -= b.y, z -= b.z, *this; }
  constexpr Vec3& operator*=(double f) noexcept { return x *= f, y *= f, z *= f, *this; }
};

constexpr Vec3 operator+(const Vec3& a, const Vec3& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3 operator-(const Vec3& a) noexcept { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(double f, const Vec3& a) noexcept { return {f * a.x, f * a.y, f * a.z}; }
constexpr Vec3 operator*(const Vec3& a, double f) noexcept { return f * a; }
constexpr Vec3 operator/(const Vec3& a, double f) noexcept { return {a.x / f, a.y / f, a.z / f}; }

constexpr double dot(const Vec3& a, const Vec3& b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double norm_squared(const Vec3& a) noexcept { return dot(a, a); }

inline double largest_component(const Vec3& a) noexcept { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }

/// Whether no component is larger than `most`, a finite number, or not finite.
inline bool is_within(const Vec3& a, double most) noexcept {
  return std::abs(a.x) <= most && std::abs(a.y) <= most && std::abs(a.z) <= most;
}

inline bool is_finite(const Vec3& a) noexcept { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

namespace detail {
// Vectors whose squares would overflow or vanish, rare: kept out of line, so that the callers' fast paths are short.
[[gnu::cold, gnu::noinline]] inline double rescaled_norm(const Vec3& a) noexcept {
  if (a == Vec3{}) return 0.0;  // most calls
  const double largest = largest_component(a);
  if (!(largest > 0.0) || !std::isfinite(largest)) return largest;
  const int exponent = std::ilogb(largest);
  const Vec3 scaled{std::scalbn(a.x, -exponent), std::scalbn(a.y, -exponent), std::scalbn(a.z, -exponent)};
  return std::scalbn(std::sqrt(norm_squared(scaled)), exponent);
}
[[gnu::cold, gnu::noinline]] inline Vec3 rescaled_direction(const Vec3& a) noexcept {
  const double largest = largest_component(a);
  if (!(largest > 0.0) || !is_finite(a)) return {};
  const int exponent = std::ilogb(largest);
  const Vec3 scaled{std::scalbn(a.x, -exponent), std::scalbn(a.y, -exponent), std::scalbn(a.z, -exponent)};
  return scaled / std::sqrt(norm_squared(scaled));
}
}  // namespace detail

/// Length, in the unit of `a`. Accurate to a few units in the last place for every finite vector: components whose squares
/// would overflow or vanish are first scaled by a power of two, for fields in unusual units. Inlined: a call costs as much.
[[gnu::always_inline]] inline double norm(const Vec3& a) noexcept {
  const double squared = norm_squared(a);
  return squared > 1e-280 && squared < 1e280 ? std::sqrt(squared) : detail::rescaled_norm(a);
}

/// Length of a − b, in their unit.
[[gnu::always_inline]] inline double distance(const Vec3& a, const Vec3& b) noexcept { return norm(a - b); }

/// Unit vector along `a`; zero where `a` is zero or not finite.
inline Vec3 normalized(const Vec3& a) noexcept {
  const double squared = norm_squared(a);
  return squared > 1e-280 && squared < 1e280 ? a / std::sqrt(squared) : detail::rescaled_direction(a);
}

/// `a`, shortened to the length `longest` >= 0, in the unit of `a`, if it is longer.
inline Vec3 shortened(const Vec3& a, double longest) noexcept {
  const double length = norm(a);
  return length > longest ? (longest / length) * a : a;
}

/// 3×3 matrix by rows. As a Jacobian: row = component of the vector field, column = axis of position.
struct Mat3 {
  Vec3 row[3];

  static constexpr Mat3 identity() noexcept { return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; }
  friend constexpr bool operator==(const Mat3& a, const Mat3& b) noexcept {
    return a.row[0] == b.row[0] && a.row[1] == b.row[1] && a.row[2] == b.row[2];
  }
};

constexpr Vec3 operator*(const Mat3& m, const Vec3& v) noexcept {
  return {dot(m.row[0], v), dot(m.row[1], v), dot(m.row[2], v)};
}
constexpr Mat3 operator*(double f, const Mat3& m) noexcept { return {{f * m.row[0], f * m.row[1], f * m.row[2]}}; }
constexpr Mat3 transposed(const Mat3& m) noexcept {
  return {{{m.row[0].x, m.row[1].x, m.row[2].x}, {m.row[0].y, m.row[1].y, m.row[2].y}, {m.row[0].z, m.row[1].z, m.row[2].z}}};
}
/// mᵀ v, without forming the transpose.
constexpr Vec3 transposed_times(const Mat3& m, const Vec3& v) noexcept {
  return v.x * m.row[0] + v.y * m.row[1] + v.z * m.row[2];
}
constexpr Mat3 operator*(const Mat3& a, const Mat3& b) noexcept {
  return {{transposed_times(b, a.row[0]), transposed_times(b, a.row[1]), transposed_times(b, a.row[2])}};
}
constexpr double determinant(const Mat3& m) noexcept { return dot(m.row[0], cross(m.row[1], m.row[2])); }
inline bool is_finite(const Mat3& m) noexcept { return is_finite(m.row[0]) && is_finite(m.row[1]) && is_finite(m.row[2]); }

/// Inverse by cofactors. The matrix must be regular (unchecked): check `determinant` first.
constexpr Mat3 inverse(const Mat3& m) noexcept {
  const Vec3 a = cross(m.row[1], m.row[2]);
  const Vec3 b = cross(m.row[2], m.row[0]);
  const Vec3 c = cross(m.row[0], m.row[1]);
  const double d = dot(m.row[0], a);
  return {{{a.x / d, b.x / d, c.x / d}, {a.y / d, b.y / d, c.y / d}, {a.z / d, b.z / d, c.z / d}}};
}

}  // namespace palpa
