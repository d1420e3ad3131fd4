// What the laws of earlier systems have in common: checks, finite answers, and the proven bound.
#pragma once

#include <memory>

#include "palpa/solver/law.h"

namespace palpa::baseline {

/// A law of an earlier system. It says where the proxy goes and which forces the primitives exert there. This class makes the
/// answer finite, keeps it within `largest_position_m`, and adds the proven distance to the exact balance (`error_bound_m`,
/// from those forces). Bad input is answered as the exact law answers it. The path on which these systems moved the proxy is in
/// path.h.
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
    double time_step_s = 0.0;  ///< usable where a primitive has a drag
    Vec3 target_m;             ///< where the proxy would be without points, lines and planes: probe + directed/k
  };
  struct Moved {
    Vec3 proxy_m;
    int iterations = 1;
  };

  /// Takes memory for sets of up to `capacity` primitives.
  explicit EarlierLaw(std::size_t capacity);

  /// The law itself. `forces_n` is as long as the set; directed forces are filled in, the others zero.
  virtual Moved move(const Posed& posed, std::span<Vec3> forces_n) noexcept = 0;

 private:
  std::size_t capacity_;
  std::size_t size_ = 0;
  std::unique_ptr<Vec3[]> forces_;
};

/// The part of `v` along the primitive's span: all of it for a point, across the direction for a line,
/// along it for a plane, none for a directed force. \param v  [its own unit, also of the result]
Vec3 part_in_span(const Primitive& primitive, const Vec3& v) noexcept;

/// The force [N] with which a primitive, alone with a spring of stiffness k, answers a pull of `pull_n` towards it: the pull
/// itself up to the strength (a plane: only outwards), above that the strength plus what its drag adds. The proxy then stays
/// (pull − force)/k away from the primitive.
Vec3 answer_n(const Primitive& primitive, const Vec3& pull_n, double stiffness_n_per_m, double time_step_s) noexcept;

}  // namespace palpa::baseline
