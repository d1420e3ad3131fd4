#include "palpa/mode/vortex_core.h"

#include <algorithm>
#include <cmath>

#include "palpa/mode/placement.h"

namespace palpa::detail {

namespace {

// [1] of the largest Q. Less: noise of measured data counts as a vortex; more: the rims of vortices are not felt.
constexpr double threshold_share = 0.05;

// [1] Regularity of the 2 × 2 system: determinant over the product that makes it regular. Below the first the core line is
// rejected, from the second on fully trusted. Smaller: steps from nearly singular systems; larger: more true cores are
// rejected.
constexpr double least_regular = 0.1, regular = 0.3;
// [1] Curvature of a ridge of Q across the slope, as a share of all curvature. Below the first there is no ridge, from the
// second on full trust. Smaller: cores in flat Q; larger: weak ridges are lost.
constexpr double least_ridge = 0.03, ridge = 0.1;

// [1] Steps towards the core, each from the direction of the last. More: slower; fewer: inaccurate where the flow draws in.
constexpr int passes = 3;

/// Axis of rotation of a flow: the real eigenvector of J where the other eigenvalues are complex, else zero.
Vec3 swirl_axis(const Mat3& jacobian) noexcept {
  const double largest =
      std::max({largest_component(jacobian.row[0]), largest_component(jacobian.row[1]), largest_component(jacobian.row[2])});
  if (!(largest > 0.0) || !std::isfinite(largest)) return {};
  const Mat3 j = (1.0 / largest) * jacobian;
  // λ = mean + t with t³ + p t + q = 0.
  const double mean = (j.row[0].x + j.row[1].y + j.row[2].z) / 3.0;
  Mat3 m = j;
  m.row[0].x -= mean, m.row[1].y -= mean, m.row[2].z -= mean;
  const double p = m.row[0].x * m.row[1].y - m.row[0].y * m.row[1].x + m.row[0].x * m.row[2].z - m.row[0].z * m.row[2].x +
                   m.row[1].y * m.row[2].z - m.row[1].z * m.row[2].y;
  const double q = -determinant(m);
  const double discriminant = 0.25 * q * q + p * p * p / 27.0;
  if (!(discriminant > 0.0)) return {};
  const double u = std::cbrt(-0.5 * q - std::copysign(std::sqrt(discriminant), q));
  const double t = u - p / (3.0 * u);
  m.row[0].x -= t, m.row[1].y -= t, m.row[2].z -= t;
  const Vec3 candidates[] = {cross(m.row[0], m.row[1]), cross(m.row[1], m.row[2]), cross(m.row[2], m.row[0])};
  const Vec3* best = &candidates[0];
  for (const Vec3& c : candidates) {
    if (norm_squared(c) > norm_squared(*best)) best = &c;
  }
  return norm_squared(*best) > 1e-24 ? normalized(*best) : Vec3{};
}

}  // namespace

CoreLine core_by_velocity(const VectorSample& velocity, const Vec3& background) noexcept {
  CoreLine core;
  if (!velocity.inside) return core;
  core.axis = swirl_axis(velocity.jacobian);
  if (core.axis == Vec3{}) return core;
  const Vec3 reduced = velocity.value - background;
  const Vec3 across = reduced - dot(reduced, core.axis) * core.axis;
  const double speed = norm(across);
  if (!(speed > 0.0)) {  // on the core itself
    core.trust = 1.0;
    return core;
  }
  // Where the flow also draws in, it does not run round the core; the step to the core is a better guess for the next pass.
  Vec3 e1 = normalized(across);
  for (int pass = 0; pass < passes; ++pass) {
    const Vec3 e2 = cross(core.axis, e1);
    const Vec3 j1 = velocity.jacobian * e1, j2 = velocity.jacobian * e2;
    const double b11 = dot(e1, j1), b21 = dot(e2, j1), b22 = dot(e2, j2), b12_itself = dot(e1, j2);
    if (!(b12_itself * b21 < 0.0)) return core;
    const double b12 = -std::copysign(std::max(std::abs(b12_itself), std::abs(b21)), b21);
    const double product = std::abs(b12 * b21);
    const double regularity = 1.0 + b11 * b22 / product;
    if (!(regularity > least_regular)) return core;
    const double v1 = dot(e1, across), v2 = dot(e2, across), scale = 1.0 / (regularity * product);
    const Vec3 offset_m = (scale * (b12 * v2 - b22 * v1)) * e1 + (scale * (b21 * v1 - b11 * v2)) * e2;
    if (!is_finite(offset_m)) return core;
    if (pass + 1 == passes) {
      core.offset_m = offset_m;
      core.trust = smooth_step(regularity, least_regular, regular);
    }
    e1 = normalized(cross(core.axis, offset_m));
    if (e1 == Vec3{}) return core;
  }
  return core;
}

CoreLine core_by_q(const ScalarSample& q, const Mat3& hessian, const VectorSample& velocity) noexcept {
  CoreLine core;
  if (!q.inside || !velocity.inside) return core;
  core.axis = swirl_axis(velocity.jacobian);
  if (core.axis == Vec3{}) return core;
  const Vec3 across = q.gradient - dot(q.gradient, core.axis) * core.axis;
  const double steepness = norm(across);
  if (!(steepness > 0.0)) {  // on the core itself, or in a core in solid rotation, which has no ridge
    const double curvature = norm(hessian.row[0]) + norm(hessian.row[1]) + norm(hessian.row[2]);
    core.trust = curvature > 0.0 ? 1.0 : 0.0;
    return core;
  }
  const Vec3 e1 = normalized(across), e2 = cross(core.axis, e1);
  const Vec3 h2 = hessian * e2;
  const double h12_itself = dot(e1, h2), h22 = dot(e2, h2), h11_itself = dot(e1, hessian * e1);
  const double h11 = std::min(h11_itself, h22);
  const double h12 = h12_itself * std::clamp(h11_itself / h11, 0.0, 1.0);  // unreliable where the profile bends
  const double product = h11 * h22;
  const double share = -h22 / (std::abs(h11_itself) + std::abs(h12_itself) + std::abs(h22));
  const double regularity = 1.0 - h12 * h12 / product;
  if (!(share > least_ridge) || !(regularity > least_regular)) return core;
  const double scale = steepness / (regularity * product);
  core.offset_m = (-h22 * scale) * e1 + (h12 * scale) * e2;
  core.trust =
      is_finite(core.offset_m) ? smooth_step(share, least_ridge, ridge) * smooth_step(regularity, least_regular, regular) : 0.0;
  return core;
}

double in_vortex_n(const ModeContext& here, const FieldRef& q, bool everywhere, double strength_n) noexcept {
  const ScalarSample sample = here.scalar(q);
  if (!sample.inside || everywhere) return sample.inside ? strength_n : 0.0;
  const double depth = sample.value - threshold_share * std::max(0.0, here.range(q).max);
  if (!(depth > 0.0)) return 0.0;
  const double steepness = norm(sample.gradient);
  const double limit_n = 0.5 * here.stiffness_n_per_m * depth / steepness;
  return steepness > 0.0 && limit_n < strength_n ? limit_n : strength_n;
}

}  // namespace palpa::detail
