// Wake of a wing, from line vortices.
#include "palpa/data/phantom_parts.h"

namespace palpa {

using namespace detail::phantom;

namespace {

constexpr double free_stream_m_per_s = 1.0, wing_circulation_m2_per_s = 0.4, wing_core_m = 0.12;

/// Straight vortex from `start` along the unit vector `along`; `length` infinite for one without end.
///
/// u = Γ/(4π) K t × r, r = x − start, K = ∫ ds/(|x − s|² + ε²)^{3/2} = (l₁/s₁ − l₂/s₂)/h², with l the distances along the line
/// from both ends, s² = l² + h² and h² = ε² + (distance from the line)².
struct LineVortex {
  Vec3 start;
  Vec3 along;
  double length_m;
  double circulation_m2_per_s;

  struct Swirling {
    Vec3 velocity;
    Mat3 jacobian;
    double rate = 0.0;  ///< ω = Γ K/(4π) [1/s]
    Vec3 rate_gradient;
    double squared_m2 = 0.0;  ///< h²
    Vec3 squared_gradient_m;
  };
  Swirling operator()(const Vec3& x) const noexcept {
    const Vec3 r = x - start;
    const double l1 = dot(r, along);
    const Vec3 across = r - l1 * along;
    Swirling v;
    v.squared_m2 = norm_squared(across) + wing_core_m * wing_core_m;
    v.squared_gradient_m = 2.0 * across;
    const double s1 = std::sqrt(v.squared_m2 + l1 * l1);
    double g = l1 / s1 + 1.0;
    Vec3 dg = (along - (l1 / (s1 * s1)) * r) / s1;
    if (std::isfinite(length_m)) {
      const double l2 = l1 - length_m;
      const double s2 = std::sqrt(v.squared_m2 + l2 * l2);
      g -= l2 / s2 + 1.0;
      dg -= (along - (l2 / (s2 * s2)) * (r - length_m * along)) / s2;
    }
    const double factor = circulation_m2_per_s / (4.0 * std::numbers::pi * v.squared_m2);
    v.rate = factor * g;
    v.rate_gradient = factor * (dg - (g / v.squared_m2) * v.squared_gradient_m);
    const Vec3 turn = cross(along, r);
    v.velocity = v.rate * turn;
    const Mat3 turning{{{0, -along.z, along.y}, {along.z, 0, -along.x}, {-along.y, along.x, 0}}};
    v.jacobian = plus(outer(turn, v.rate_gradient), v.rate * turning);
    return v;
  }
};

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr LineVortex wing_vortices[] = {
    {{0.25, -1.4, 0}, {0, 1, 0}, 2.8, wing_circulation_m2_per_s},
    {{0.25, 1.4, 0}, {1, 0, 0}, endless, wing_circulation_m2_per_s},
    {{0.25, -1.4, 0}, {1, 0, 0}, endless, -wing_circulation_m2_per_s},
};

VectorSample wake_velocity(const Vec3& x) noexcept {
  VectorSample s{{free_stream_m_per_s, 0, 0}, {}, true};
  for (const LineVortex& vortex_line : wing_vortices) {
    const LineVortex::Swirling v = vortex_line(x);
    s.value += v.velocity;
    s.jacobian = plus(s.jacobian, v.jacobian);
  }
  return s;
}

ScalarSample wake_pressure(const Vec3& x) noexcept {
  ScalarSample s{0.0, {}, true};
  for (const LineVortex& vortex_line : wing_vortices) {
    const LineVortex::Swirling v = vortex_line(x);
    s.value -= free_stream_m_per_s * v.velocity.x + 0.5 * v.rate * v.rate * v.squared_m2;
    s.gradient -= free_stream_m_per_s * v.jacobian.row[0] + v.rate * v.squared_m2 * v.rate_gradient +
                  0.5 * v.rate * v.rate * v.squared_gradient_m;
  }
  return s;
}

}  // namespace

Volume wing_wake() {
  constexpr Box box{{-0.5, -1.9, -0.6}, {3.0, 1.9, 0.6}};
  // A vortex of circulation Γ causes rotation of at most Γ/(4πε); three of them add up at most.
  constexpr double fastest = wing_circulation_m2_per_s / (4.0 * std::numbers::pi * wing_core_m);
  constexpr double u = free_stream_m_per_s;
  Volume volume =
      volume_of("velocity", "m/s", box, 0.25 * wing_core_m,
                {{u - fastest, u + fastest}, {-2.0 * fastest, 2.0 * fastest}, {-3.0 * fastest, 3.0 * fastest}}, wake_velocity);
  add_field(volume, "pressure", "m²/s²", {{-u * fastest - 6.0 * fastest * fastest, u * fastest}}, wake_pressure);
  return volume;
}

}  // namespace palpa
