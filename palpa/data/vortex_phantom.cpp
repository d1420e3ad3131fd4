// Vortices with closed forms.
#include "palpa/data/phantom_parts.h"

namespace palpa {

using namespace detail::phantom;

namespace {

/// φ(s) = (1 − exp(−s))/s and dφ/ds. Near s = 0 both are differences of nearly equal numbers; there the series Σ (−s)ⁿ/(n+1)!
/// is used, whose 17 terms are exact to rounding below s = 1/2.
struct Swirl {
  double phi;
  double slope;
};
Swirl swirl(double s) noexcept {
  if (s < 0.5) {
    double factorial = 355687428096000.0;  // 17!
    double phi = 1.0 / factorial;          // term n = 16 of φ, without its power of −s
    double slope = 0.0;
    for (int n = 16; n >= 1; --n) {
      slope = slope * -s + n / factorial;
      factorial /= n + 1;
      phi = phi * -s + 1.0 / factorial;
    }
    return {phi, -slope};
  }
  const double decay = std::exp(-s);
  return {(1.0 - decay) / s, (decay * (1.0 + s) - 1.0) / (s * s)};
}

/// u = ω (−y, x, 0) + a (−x/2, −y/2, z) with ω = Γ/(2πr_c²) φ(r²/r_c²): one expression for both vortices, without a division by
/// r.
struct Vortex {
  double core_radius_m;
  double axis_rate_per_s;  ///< Γ/(2πr_c²), ω on the axis
  double strain_per_s;

  VectorSample operator()(const Vec3& x) const noexcept {
    const double px = x.x / core_radius_m, py = x.y / core_radius_m;
    const Swirl f = swirl(px * px + py * py);
    const double w = axis_rate_per_s * f.phi;
    const double bend = 2.0 * axis_rate_per_s * f.slope;  // r_c dω/dx = bend · x/r_c
    const double a = strain_per_s;
    VectorSample s;
    s.inside = true;
    s.value = {-w * x.y - 0.5 * a * x.x, w * x.x - 0.5 * a * x.y, a * x.z};
    s.jacobian = {{{-0.5 * a - bend * px * py, -w - bend * py * py, 0.0},
                   {w + bend * px * px, -0.5 * a + bend * px * py, 0.0},
                   {0.0, 0.0, a}}};
    return s;
  }
};

Volume vortex(double circulation_m2_per_s, double core_radius_m, double strain_per_s) {
  check_length("a vortex's core radius", core_radius_m);
  if (!std::isfinite(strain_per_s) || strain_per_s < 0.0) {
    throw std::invalid_argument("a vortex's strain is " + detail::text("%g", strain_per_s) + "; it must be 0 1/s or more");
  }
  const double rate = circulation_m2_per_s / (2.0 * std::numbers::pi * core_radius_m * core_radius_m);
  if (!std::isfinite(rate)) throw std::invalid_argument("a vortex's circulation must be finite, also over its core's area");
  const double half_m = 6.0 * core_radius_m;
  constexpr double s = 1.2564312086261697;  // argument of the largest u_t: 1 + 2s = exp(s)
  const double fastest = std::abs(rate) * core_radius_m * (1.0 - std::exp(-s)) / std::sqrt(s);
  const double across = fastest + 0.5 * strain_per_s * half_m, along = strain_per_s * half_m;
  return volume_of("velocity", "m/s", cube(half_m), core_radius_m / 8.0,
                   {{-across, across}, {-across, across}, {-along, along}}, Vortex{core_radius_m, rate, strain_per_s});
}

}  // namespace

Volume lamb_oseen_vortex(double circulation_m2_per_s, double core_radius_m) {
  return vortex(circulation_m2_per_s, core_radius_m, 0.0);
}

Volume burgers_vortex(double circulation_m2_per_s, double core_radius_m, double strain_per_s) {
  return vortex(circulation_m2_per_s, core_radius_m, strain_per_s);
}

}  // namespace palpa
