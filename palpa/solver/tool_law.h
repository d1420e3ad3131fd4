// Law of a tool's balance: the scene's law for a point, the exact law in six unknowns for a body.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "palpa/solver/pose_solver.h"

namespace palpa {

/// Balances of a tool from the start of a move. A point uses a Law, to the bit as without a tool. Allocates at construction
/// only; one thread.
class ToolLaw {
 public:
  /// \param law       of a point tool; unused by another
  /// \param tool      outlives this
  /// \param capacity  [1] of primitives
  ToolLaw(std::unique_ptr<Law> law, const Tool& tool, std::size_t capacity);

  /// Starts a move at `start` [m].
  void begin_move(const Pose& start) noexcept {
    start_ = start;
    if (!tool_.is_point()) turn_levers();
  }
  /// Balance of a set that starts there, for the device at `probe` [m].
  Balance solve(const PrimitiveSet& set, const Pose& probe, double stiffness_n_per_m, double time_step_s) noexcept {
    if (tool_.is_point()) return law_->solve(set, set.start_m(), probe.position_m, stiffness_n_per_m, time_step_s);
    return solve_body(set, probe, stiffness_n_per_m, time_step_s);
  }
  std::span<const Vec3> forces_n() const noexcept { return tool_.is_point() ? law_->forces_n() : pose_law_->forces_n(); }
  void reset() noexcept;
  /// Force of each row by which friction is measured [N]: of a point the law's; of a tool the least split of the load on the
  /// planes and corners of the last balance `found`, which does not depend on a warm start. Valid until the next call.
  std::span<const Vec3> loads_n(const PrimitiveSet& set, const Balance& found) noexcept;

  const Tool& tool() const noexcept { return tool_; }
  /// From the device's point to a foot at the start of the move [m].
  const Vec3& lever_m(const PrimitiveId& id) const noexcept { return levers_m_[id.foot]; }
  /// Calls `visit` with a balance as the foot of a primitive has it.
  template <class Visit>
  auto at_foot(const Balance& balance, const PrimitiveId& id, Visit&& visit) const noexcept {
    return tool_.is_point() ? visit(balance) : visit(balance_at_foot(balance, lever_m(id), tool_.turning_radius_m()));
  }
  /// Largest residual motion of a foot per force at it, times the stiffness [1]: 1 for a point.
  double gain(const PrimitiveId& id) const noexcept {
    return tool_.is_point() ? 1.0 : 1.0 + norm_squared(lever_m(id) / tool_.turning_radius_m());
  }
  /// Pose of a balance of this move; the device's to the bit where it is there.
  Pose pose_of(const Balance& balance, const Pose& probe) const noexcept {
    Pose pose{balance.position_m, start_.turn};
    if (!tool_.is_point()) {
      const Pose of_body = body_pose_of(balance, probe);  // a variable of its own: see Tool
      pose = of_body;
    }
    return pose;
  }
  /// Position of a foot [m] with the tool moved to `end`, had it gone on the straight line of its linear motion: primitives act
  /// there. Of a point its position.
  Vec3 linear_foot_m(const PrimitiveId& id, const Pose& end) const noexcept;

 private:
  void turn_levers() noexcept;
  Balance solve_body(const PrimitiveSet& set, const Pose& probe, double stiffness_n_per_m, double time_step_s) noexcept;
  Pose body_pose_of(const Balance& balance, const Pose& probe) const noexcept;

  std::unique_ptr<Law> law_;
  std::unique_ptr<PoseSolver> pose_law_;
  const Tool& tool_;
  Pose start_;
  std::vector<Vec3> levers_m_;  // by foot
  // Rotation from the start of the move to the end of the last linear foot: that of all feet.
  struct Rotation {
    Turn to;
    Vec3 rotation_rad;
  };
  mutable Rotation seen_;
  // Of the planes and corners of a set, and of all of its rows:
  std::vector<Primitive> planes_;
  std::vector<Vec3> plane_levers_m_, plane_forces_n_, loads_n_;
};

}  // namespace palpa
