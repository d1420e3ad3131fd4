// Analytic fields, and the shapes of phantoms. Internal.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/data/analytic.h"
#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"

namespace palpa::detail::phantom {

/// Formula over its box; no data outside. `Law` returns a ScalarSample or a VectorSample.
template <class Law>
class Formula final : public Field {
 public:
  Formula(const Box& box, double spacing_m, std::vector<ValueRange> value_ranges, Law law)
      : box_(box), spacing_m_(spacing_m), extents_(std::move(value_ranges)), law_(std::move(law)) {}

  int components() const noexcept override { return is_vector ? 3 : 1; }
  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    if constexpr (!is_vector) {
      if (!holds(world_m)) return {};
      const ScalarSample s = law_(world_m);
      if (std::isfinite(s.value) && is_finite(s.gradient)) return s;
    }
    return {};
  }
  VectorSample vector(const Vec3& world_m) const noexcept override {
    if constexpr (is_vector) {
      if (!holds(world_m)) return {};
      const VectorSample s = law_(world_m);
      if (is_finite(s.value) && is_finite(s.jacobian)) return s;
    }
    return {};
  }
  double spacing_m() const noexcept override { return spacing_m_; }
  Box bounds_m() const noexcept override { return box_; }
  double depth_m(const Vec3& world_m) const noexcept override {
    const Vec3 low = world_m - box_.low_m, high = box_.high_m - world_m;
    const double depth = std::min({low.x, low.y, low.z, high.x, high.y, high.z});
    return is_finite(low) && is_finite(high) ? depth : 0.0;
  }
  std::vector<ValueRange> value_ranges() const override { return extents_; }

 private:
  static constexpr bool is_vector = std::is_same_v<decltype(std::declval<Law>()(Vec3{})), VectorSample>;

  bool holds(const Vec3& x) const noexcept {
    return x.x >= box_.low_m.x && x.x <= box_.high_m.x && x.y >= box_.low_m.y && x.y <= box_.high_m.y && x.z >= box_.low_m.z &&
           x.z <= box_.high_m.z;
  }

  Box box_;
  double spacing_m_;
  std::vector<ValueRange> extents_;
  Law law_;
};

template <class Law>
Volume volume_of(std::string name, std::string unit, const Box& box, double spacing_m, std::vector<ValueRange> value_ranges,
                 Law law) {
  Volume volume;
  volume.format = "formula";
  volume.fields.push_back({std::move(name), std::move(unit),
                           std::make_shared<const Formula<Law>>(box, spacing_m, std::move(value_ranges), std::move(law))});
  return volume;
}

template <class Law>
void add_field(Volume& volume, std::string name, std::string unit, std::vector<ValueRange> value_ranges, Law law) {
  const Field& first = *volume.fields.front().field;
  volume.fields.push_back(
      volume_of(std::move(name), std::move(unit), first.bounds_m(), first.spacing_m(), std::move(value_ranges), std::move(law))
          .fields.front());
}

inline Box cube(double half_m) { return {{-half_m, -half_m, -half_m}, {half_m, half_m, half_m}}; }

inline Mat3 plus(const Mat3& a, const Mat3& b) noexcept {
  return {{a.row[0] + b.row[0], a.row[1] + b.row[1], a.row[2] + b.row[2]}};
}
inline Mat3 outer(const Vec3& a, const Vec3& b) noexcept { return {{a.x * b, a.y * b, a.z * b}}; }

inline void check_length(const char* what, double length_m) {
  if (std::isfinite(length_m) && length_m > 0.0) return;
  throw std::invalid_argument(std::string(what) + " is " + detail::text("%g", length_m) + "; it must be a length above 0 m");
}

/// Signed distance to a shape [m], negative inside, and its gradient [1]: true to first order near the surface; far from it
/// only the sign and a large magnitude, enough for an edge of 2 mm.
struct Distance {
  double d;
  Vec3 g;
};

struct Ellipsoid {
  Vec3 centre;
  Vec3 inverse_squared;
  double smallest;

  /// Centre and semi-axes in millimetres.
  constexpr Ellipsoid(Vec3 centre_mm, Vec3 semi_axes_mm)
      : centre(1e-3 * centre_mm),
        inverse_squared{1e6 / (semi_axes_mm.x * semi_axes_mm.x), 1e6 / (semi_axes_mm.y * semi_axes_mm.y),
                        1e6 / (semi_axes_mm.z * semi_axes_mm.z)},
        smallest(1e-3 * std::min({semi_axes_mm.x, semi_axes_mm.y, semi_axes_mm.z})) {}

  static constexpr Vec3 times(const Vec3& a, const Vec3& b) noexcept { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

  /// d = k₀(k₀ − 1)/k₁ with k₀ = |x/a|, k₁ = |x/a²| (a: the semi-axes).
  Distance operator()(const Vec3& x) const noexcept {
    const Vec3 r = x - centre;
    const Vec3 u = times(r, inverse_squared);
    const double squared = dot(r, u);
    if (squared < 0.04) return {-0.5 * smallest, {}};  // deep inside, where the expression is singular
    const double k0 = std::sqrt(squared);
    const double inverse_k1 = 1.0 / std::sqrt(norm_squared(u));
    const double d = k0 * (k0 - 1.0) * inverse_k1;
    return {d, (2.0 - 1.0 / k0) * inverse_k1 * u - d * inverse_k1 * inverse_k1 * times(u, inverse_squared)};
  }
};

struct Capsule {
  Vec3 start;
  Vec3 axis;
  double radius;

  constexpr Capsule(Vec3 start_mm, Vec3 end_mm, double radius_mm)
      : start(1e-3 * start_mm), axis(1e-3 * (end_mm - start_mm)), radius(1e-3 * radius_mm) {}

  Distance operator()(const Vec3& x) const noexcept {
    const Vec3 from_start = x - start;
    const double t = std::clamp(dot(from_start, axis) / norm_squared(axis), 0.0, 1.0);
    const Vec3 r = from_start - t * axis;
    const double length = std::sqrt(norm_squared(r));
    return {length - radius, length > 0.0 ? r / length : Vec3{}};
  }
};

/// Box with rounded edges.
struct RoundBox {
  Vec3 centre;
  Vec3 half;  ///< of the box before rounding
  double radius;

  constexpr RoundBox(Vec3 centre_mm, Vec3 half_mm, double radius_mm)
      : centre(1e-3 * centre_mm), half(1e-3 * half_mm), radius(1e-3 * radius_mm) {}

  Distance operator()(const Vec3& x) const noexcept {
    const Vec3 r = x - centre;
    const Vec3 q{std::max(std::abs(r.x) - half.x, 0.0), std::max(std::abs(r.y) - half.y, 0.0),
                 std::max(std::abs(r.z) - half.z, 0.0)};
    const double length = std::sqrt(norm_squared(q));
    if (!(length > 0.0)) return {-radius, {}};
    return {length - radius, Vec3{std::copysign(q.x, r.x), std::copysign(q.y, r.y), std::copysign(q.z, r.z)} / length};
  }
};

/// Union of two shapes, with the crease between them filled over a width.
inline Distance joined(const Distance& a, const Distance& b, double width_m) noexcept {
  const double h = std::clamp(0.5 + 0.5 * (b.d - a.d) / width_m, 0.0, 1.0);
  return {b.d + h * (a.d - b.d) - width_m * h * (1.0 - h), h * a.g + (1.0 - h) * b.g};
}
inline Distance negated(const Distance& a) noexcept { return {-a.d, -a.g}; }
/// Intersection of two shapes, its crease rounded over a width.
inline Distance shared(const Distance& a, const Distance& b, double width_m) noexcept {
  return negated(joined(negated(a), negated(b), width_m));
}
inline Distance grown(const Distance& a, double by_m) noexcept { return {a.d - by_m, a.g}; }

// Width of all edges, two sample spacings. Less: gradients are missed between samples; more: thin bone fades.
inline constexpr double edge_m = 2e-3;

/// 1 inside, 0 outside, a quintic between with continuous value, slope and curvature.
struct Weight {
  double w;
  Vec3 g;
};
inline Weight weight_of(const Distance& a) noexcept {
  const double t = 0.5 - a.d / edge_m;
  if (t <= 0.0) return {0.0, {}};
  if (t >= 1.0) return {1.0, {}};
  const double rest = 1.0 - t;
  return {t * t * t * (10.0 + t * (6.0 * t - 15.0)), (-30.0 * t * t * rest * rest / edge_m) * a.g};
}

/// Paints a shape over the sample.
inline void paint(ScalarSample& onto, double value_hu, const Distance& shape) noexcept {
  const Weight a = weight_of(shape);
  onto.gradient = (1.0 - a.w) * onto.gradient + (value_hu - onto.value) * a.g;
  onto.value += a.w * (value_hu - onto.value);
}

}  // namespace palpa::detail::phantom
