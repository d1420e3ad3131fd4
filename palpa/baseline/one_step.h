// The exact law without a path.
#pragma once

#include "palpa/core/solver.h"

namespace palpa::baseline {

/// The exact balance once per tick: what is left of an earlier system when its solver is blameless. What shows that it is the
/// path, and not the balance, that a difference comes from.
class OneStep final : public Law {
 public:
  Walk walk() const noexcept override { return Walk::one; }
  Balance solve(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                double time_step_s) noexcept override {
    return solver_.solve(primitives, start_m, probe_m, stiffness_n_per_m, time_step_s);
  }
  std::span<const Vec3> forces_n() const noexcept override { return solver_.forces_n(); }
  void reset() noexcept override { solver_.reset(); }

 private:
  Solver solver_;
};

}  // namespace palpa::baseline
