// Where a mode puts its primitives.
#pragma once

#include "palpa/core/primitives.h"

namespace palpa {

/// The set of a sub-step as a mode sees it: it can add primitives of its own, and neither read nor change those of others.
/// Each function is that of `PrimitiveSet`, which refuses what could not be solved. Passed by value: a reference.
class PrimitiveSink {
 public:
  PrimitiveSink(PrimitiveSet& set) noexcept : set_(set) {}  // NOLINT: every set is one

  /// Holds the proxy at `position_m` in every direction.
  void point(std::uint16_t slot, const Vec3& position_m, double strength_n, double drag_ns_per_m = 0.0) const noexcept {
    set_.point(slot, position_m, strength_n, drag_ns_per_m);
  }
  /// Holds the proxy across the unit vector `direction` [1].
  void line(std::uint16_t slot, const Vec3& position_m, const Vec3& direction, double strength_n,
            double drag_ns_per_m = 0.0) const noexcept {
    set_.line(slot, position_m, direction, strength_n, drag_ns_per_m);
  }
  /// Pushes along the unit vector `normal` [1] while the proxy is behind it.
  /// \param captured  the level that it stands on: the tick lets no step cross that level
  void plane(std::uint16_t slot, const Vec3& position_m, const Vec3& normal, double strength_n, Captured captured = {},
             double drag_ns_per_m = 0.0) const noexcept {
    set_.plane(slot, position_m, normal, strength_n, captured, drag_ns_per_m);
  }
  /// One that gives way by its force over `stiffness_n_per_m`, > 0; `normal` [1].
  void elastic_plane(std::uint16_t slot, const Vec3& position_m, const Vec3& normal, double strength_n,
                     double stiffness_n_per_m, Captured captured = {}) const noexcept {
    set_.elastic_plane(slot, position_m, normal, strength_n, stiffness_n_per_m, captured);
  }
  /// A force of `strength_n` along the unit vector `direction` [1].
  void directed(std::uint16_t slot, const Vec3& direction, double strength_n) const noexcept {
    set_.directed(slot, direction, strength_n);
  }
  /// A line through the plane of slot `plane_slot`, placed before, as strong as `coefficient` [1] times that plane's force.
  void friction(std::uint16_t slot, std::uint16_t plane_slot, const Vec3& position_m, double coefficient,
                double drag_ns_per_m = 0.0) const noexcept {
    set_.friction(slot, plane_slot, position_m, coefficient, drag_ns_per_m);
  }

 private:
  PrimitiveSet& set_;
};

}  // namespace palpa
