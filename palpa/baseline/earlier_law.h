// Common base of earlier systems' laws: checks, finite results, and the proven bound.
#pragma once

#include <memory>

#include "palpa/solver/law.h"

namespace palpa::baseline {

/// Law of an earlier system: the proxy, and the forces of the primitives there. This class makes the result finite, keeps it
/// within `largest_position_m`, and adds the proven distance to the exact balance (`error_bound_m`, from these forces). Handles
/// bad input as the exact law does. The path of these systems' proxy is `Steps` (proxy_path.h).
class EarlierLaw : public Law {
 public:
  Balance solve(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                double time_step_s) noexcept final;
  std::span<const Vec3> forces_n() const noexcept final { return {forces_.get(), size_}; }
  void reset() noexcept override { size_ = 0; }

 protected:
  struct Posed {
    std::span<const Primitive> primitives;  ///< at least one
    Vec3 start_m;
    Vec3 probe_m;
    double stiffness_n_per_m = 0.0;
    double time_step_s = 0.0;  ///< valid if a primitive has a drag
    Vec3 target_m;             ///< the proxy without points, lines and planes: probe + directed/k
  };
  struct Moved {
    Vec3 proxy_m;
    int iterations = 1;
  };

  /// Allocates for sets of up to `capacity` [1] primitives.
  explicit EarlierLaw(std::size_t capacity);

  /// Moves the proxy by the law. `forces_n` is as long as the set; directed forces are filled in, the others zero.
  virtual Moved move(const Posed& posed, std::span<Vec3> forces_n) noexcept = 0;

 private:
  std::size_t capacity_;
  std::size_t size_ = 0;
  std::unique_ptr<Vec3[]> forces_;
};

/// Component of `v` in the primitive's span: all of it for a point, across the direction for a line, along it for a plane, zero
/// for a directed force. \param v  [its own unit, also of the result]
Vec3 part_in_span(const Primitive& primitive, const Vec3& v) noexcept;

/// Force [N] of a primitive, alone with a spring of stiffness k, in response to a pull of `pull_n` towards it: the pull itself
/// up to the strength (a plane: only outwards), above that the strength plus its drag's part. The proxy stays (pull − force)/k
/// away.
Vec3 answer_n(const Primitive& primitive, const Vec3& pull_n, double stiffness_n_per_m, double time_step_s) noexcept;

}  // namespace palpa::baseline
