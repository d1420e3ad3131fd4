#include "tests/path/bumpy_sphere.h"

#include <algorithm>
#include <numbers>

#include "palpa/device/sine_cosine.h"

namespace palpa::test {

namespace {

detail::SineCosine of_angle(double angle_rad) noexcept { return detail::sine_cosine(angle_rad / (2.0 * std::numbers::pi)); }

}  // namespace

double BumpySphere::reach_m(const Vec3& n) const noexcept {
  return radius_m_ * (1.0 + 0.05 * of_angle(5 * n.x).sine * of_angle(5 * n.y).sine * of_angle(5 * n.z).sine);
}

Vec3 BumpySphere::slope(const Vec3& x_m, double& value_m) const noexcept {
  const double r = norm(x_m);
  const Vec3 n = r > 0.0 ? x_m / r : Vec3{0, 0, 1};
  const auto [sx, cx] = of_angle(5 * n.x);
  const auto [sy, cy] = of_angle(5 * n.y);
  const auto [sz, cz] = of_angle(5 * n.z);
  const Vec3 d = 0.25 * radius_m_ * Vec3{cx * sy * sz, sx * cy * sz, sx * sy * cz};
  value_m = radius_m_ * (1.0 + 0.05 * sx * sy * sz) - r;
  return (d - dot(d, n) * n) / std::max(r, 1e-9) - n;
}

double BumpySphere::depth_m(const Vec3& x_m) const noexcept {
  double value_m = 0.0;
  const Vec3 g = slope(x_m, value_m);
  return value_m / norm(g);
}

Vec3 BumpySphere::normal(const Vec3& x_m) const noexcept {
  double value_m = 0.0;
  return -normalized(slope(x_m, value_m));
}

// Newton onto the surface, then along it towards the point: contracts by depth × curvature.
Vec3 BumpySphere::nearest_m(const Vec3& x_m) const noexcept {
  Vec3 y = x_m;
  for (int i = 0; i < 200; ++i) {
    double value_m = 0.0;
    const Vec3 g = slope(y, value_m);
    const Vec3 n = normalized(g);
    const Vec3 away = x_m - y;
    const Vec3 step = (away - dot(away, n) * n) - (value_m / norm(g)) * n;
    y += step;
    if (norm(step) < 1e-13) break;
  }
  return y;
}

}  // namespace palpa::test
