// Exact law of a tool: the balance of a rigid body with many feet, in six unknowns.
#pragma once

#include <memory>
#include <span>

#include "palpa/solver/law.h"
#include "palpa/solver/tool.h"

namespace palpa {

/// Arguments of a tool's balance besides its primitives.
struct ToolStep {
  Pose start;                      ///< [m] the tool before this sub-step
  Pose probe;                      ///< [m] the device
  std::span<const Vec3> levers_m;  ///< by foot, from the device's point, at the start
  double stiffness_n_per_m = 0.0;  ///< k of Eq. 1, > 0
  double turning_radius_m = 0.0;   ///< ρ > 0: the rotational stiffness is kρ²
  double time_step_s = 0.0;        ///< T of the sub-step, > 0 if a primitive has a drag; else unused

  /// Position of a foot [m] at the start.
  Vec3 foot_m(std::size_t foot) const noexcept { return start.position_m + levers_m[foot]; }
};

/// Finds the motion (ξ, ω) of a tool from its start that minimises
///     E(ξ, ω) = k/2 |x + ξ − p|² + κ/2 |ω − φ|² − Σ directed·(ξ + ω × b) + Σ φ(r)      (sum over the primitives)
/// with φ the rotation vector from the tool's to the device's orientation, κ = kρ², and each primitive's residual r at its
/// foot, b from the device's point, displaced by ξ + ω × b. It is the problem of Law with J (ξ, ρω) = ξ + ω × b in place of the
/// motion of the proxy: convex, with one minimiser, and a proven bound in the metric of Motion (docs/theory.md 10). Stages, in
/// order until the duality gap proves the balance: a sweep, the active set of sticking and slipping primitives with a 6×6
/// system, multipliers. All are capped; at the cap the best balance so far is returned with its bound.
///
/// Keeps the forces of the last balance for a warm start: one session and one thread. `solve` never allocates, throws, blocks,
/// or returns a value that is not finite.
class PoseSolver {
 public:
  /// Allocates for sets of up to `capacity` [1] primitives at `feet` [1] feet. Throws std::bad_alloc.
  PoseSolver(std::size_t capacity, std::size_t feet);
  ~PoseSolver();

  /// Solves for the tool's pose: `position_m` and `turn_rad`; `error_bound_m` is of the motion in the metric of Motion. Returns
  /// `bad_input`, with the start as pose and zero forces, for the k and T that Solver refuses, ρ outside of 1e-6 to 1e3 m, a
  /// pose or lever that is not finite or too large, a turn that is no unit quaternion, a primitive's foot without a lever, or a
  /// set larger than the capacity.
  Balance solve(const PrimitiveSet& primitives, const ToolStep& step) noexcept;

  /// Force of each primitive on its foot [N] at the last balance, in the set's order; valid until the next `solve`. For
  /// redundant primitives one of several valid splits.
  std::span<const Vec3> forces_n() const noexcept { return {forces_.get(), size_}; }
  /// Clears the warm start.
  void reset() noexcept { size_ = 0; }

  /// Proven bound [m] of the distance, in the metric of Motion, of the pose `at` (`position_m` and `turn_rad`) from the exact
  /// balance, for any pose and any forces: the certificate of docs/theory.md 10.2, rounding included. Projects `forces_n` on
  /// the admissible forces of each primitive. The largest double (no proof) for arguments that `PoseSolver::solve` refuses or a
  /// force that is not finite. Allocates; throws std::bad_alloc.
  static double error_bound_m(const PrimitiveSet& primitives, std::span<const Vec3> forces_n, const ToolStep& step,
                              const Balance& at);

 private:
  class Work;
  void match(std::span<const Primitive> primitives) noexcept;

  std::size_t capacity_, feet_;
  std::size_t size_ = 0;
  std::unique_ptr<Vec3[]> forces_;
  std::unique_ptr<PrimitiveId[]> ids_;
  std::unique_ptr<Work> work_;
};

/// Balance of a tool as a foot at `lever_m` [m] from the device's point has it: the position of the foot on its linear way, and
/// the bound there, at most √(1 + |b|²/ρ²) of that of the motion. For a zero lever the balance itself.
Balance balance_at_foot(const Balance& balance, const Vec3& lever_m, double turning_radius_m) noexcept;

}  // namespace palpa
