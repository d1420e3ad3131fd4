// A solid with a closed-form surface, for tests and benchmarks.
#pragma once

#include "palpa/solver/vec3.h"

namespace palpa::test {

/// A sphere with bumps: |x| = R (1 + 0.05 sin 5n_x sin 5n_y sin 5n_z), n = x/|x|. Smooth everywhere. Bit-identical on every
/// machine with IEEE arithmetic: volumes made of it have published checksums (bench/haptics).
class BumpySphere {
 public:
  explicit BumpySphere(double radius_m) : radius_m_(radius_m) {}
  /// Distance from the centre [m] to the surface along the unit vector n [1].
  double reach_m(const Vec3& n) const noexcept;
  /// The implicit function scaled to distance.
  double depth_m(const Vec3& x_m) const noexcept;
  /// Outward unit normal of the implicit function's isosurface.
  Vec3 normal(const Vec3& x_m) const noexcept;
  /// The nearest point of the surface, for points nearer to it than its radii of curvature.
  Vec3 nearest_m(const Vec3& x_m) const noexcept;

 private:
  Vec3 slope(const Vec3& x_m, double& value_m) const noexcept;
  double radius_m_;
};

}  // namespace palpa::test
