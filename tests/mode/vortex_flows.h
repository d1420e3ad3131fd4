// Vortices with known cores, sampled on skewed grids, with noise.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "palpa/data/derived.h"
#include "palpa/data/grid.h"
#include "tests/solver/random_problems.h"

namespace palpa::test {

/// A straight vortex along `axis` through the origin: angular speed Ω φ(r²/r_c²), with φ(s) = (1 − e^−s)/s, or Ω and then
/// irrotational where it turns like a solid (Rankine); strain a along the axis (Burgers), jet w e^(−r²/r_c²) along it
/// (Batchelor), all advected by `across`.
struct StraightVortex {
  double core_m = 0.01;
  double rate_per_s = 30.0;
  double strain_per_s = 0.0;
  double jet_m_per_s = 0.0;
  bool solid = false;
  Vec3 axis{0, 0, 1};
  Vec3 across_m_per_s{};

  double peak_m_per_s() const { return 0.6382 * rate_per_s * core_m; }
  Vec3 radial_m(const Vec3& x) const { return x - dot(x, axis) * axis; }
  Vec3 velocity(const Vec3& x) const {
    const Vec3 r = radial_m(x);
    const double s = norm_squared(r) / (core_m * core_m);
    const double turning = solid ? std::min(1.0, 1.0 / s) : s > 1e-12 ? -std::expm1(-s) / s : 1.0;
    return rate_per_s * turning * cross(axis, r) - 0.5 * strain_per_s * r +
           (strain_per_s * dot(x, axis) + jet_m_per_s * std::exp(-s)) * axis + across_m_per_s;
  }
};

/// Rings about the z axis, relative to a point of the core line: the origin lies on it, the axis at x = −R.
struct Ring {
  double radius_m = 0.05;
  double core_m = 0.01;
  Vec3 centred_m(const Vec3& x) const { return x + Vec3{radius_m, 0, 0}; }
  /// From a point to the nearest point of the core line.
  Vec3 to_core_m(const Vec3& x) const {
    const Vec3 c = centred_m(x);
    return radius_m * normalized({c.x, c.y, 0}) - c;
  }
};

/// A Lamb–Oseen vortex swept round the axis: in every plane through the axis the flow circles the core line.
struct SweptRing : Ring {
  double rate_per_s = 30.0;
  Vec3 velocity(const Vec3& x) const {
    const Vec3 c = centred_m(x), out = normalized({c.x, c.y, 0}), r = -to_core_m(x);
    const double s = norm_squared(r) / (core_m * core_m);
    return rate_per_s * (s > 1e-12 ? -std::expm1(-s) / s : 1.0) * (dot(r, out) * Vec3{0, 0, 1} - r.z * out);
  }
};

/// A thin ring of vorticity with a Gaussian profile, the momentary state in a fluid: elements of the core line, each spread as
/// exp(−r²/r_c²), by Biot and Savart. The flow circles a line beside the profile's centre, which differs between observers.
struct GaussianRing : Ring {
  double circulation_m2_per_s = 0.02;
  static constexpr int elements = 96;
  Vec3 velocity(const Vec3& x) const {
    Vec3 sum;
    for (int i = 0; i < elements; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / elements;
      const Vec3 along{-std::sin(angle), std::cos(angle), 0};
      const Vec3 r = centred_m(x) - radius_m * Vec3{std::cos(angle), std::sin(angle), 0};
      const double p = norm(r) / core_m;
      const double share = p > 1e-3 ? (std::erf(p) - 2.0 * std::numbers::inv_sqrtpi * p * std::exp(-p * p)) / (p * p * p)
                                    : 4.0 / 3.0 * std::numbers::inv_sqrtpi;
      sum += share * cross(along, r);
    }
    return circulation_m2_per_s * radius_m / (2.0 * elements * core_m * core_m * core_m) * sum;
  }
};

/// A cube of n³ samples of a flow about the origin, randomly turned and shifted, float as in files, with normal noise of
/// `noise_m_per_s` on every component.
template <class Flow>
FieldPtr sampled_anyhow(const Flow& flow, double step_m, int n, double noise_m_per_s, Random& random) {
  const Mat3 turn = random.rotation();
  const Vec3 shift = random.in_cube(0.5);
  const double middle = 0.5 * (n - 1);
  const GridGeometry geometry{{n, n, n}, step_m * turn, turn * (-step_m * (Vec3{middle, middle, middle} + shift))};
  const auto values = std::make_shared<std::vector<float>>();
  values->reserve(std::size_t{3} * n * n * n);
  std::mt19937 engine(static_cast<unsigned>(1e6 * random.uniform(0, 1)));
  std::normal_distribution<double> normal(0.0, 1.0);
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const Vec3 u = flow.velocity(geometry.to_world({double(i), double(j), double(k)}));
        for (const double c : {u.x, u.y, u.z}) values->push_back(static_cast<float>(c + noise_m_per_s * normal(engine)));
      }
    }
  }
  return grid_field(geometry, {VoxelType::float32, 3, std::shared_ptr<const void>(values, values->data())});
}

}  // namespace palpa::test
