// Exact law: dual sweeps, a stick/slip active set and a method of multipliers, each with its proof.
#pragma once

#include <memory>

#include "palpa/solver/law.h"

namespace palpa {

/// Computes the balance, with a proven error bound.
///
/// The dual variables of E (see Law) are the primitives' forces u; x = probe + (directed + Σu)/k. Three stages run in order
/// until the duality gap proves the balance; the derivations stand above each in solver.cpp, the theory in docs/theory.md:
///   1. sweeps: each force in turn is optimised, the others fixed. One sweep solves mutually orthogonal
///      primitives exactly; points with a common anchor are summed in closed form. A single primitive,
///      a surface with friction and a corner with one holding facet finish here, up to rounding;
///   2. active set: the forces determine the sticking and slipping primitives; a 3×3 system gives the balance
///      for this choice, which determines the next choice;
///   3. multipliers: the fallback, convergent from any start (up to the cap).
/// All iterations are capped; at the cap the best balance so far is returned with its bound. Returns `bad_input`, the start as
/// position and zero forces, for k outside of 1e-12 to 1e12 N/m, T <= 0 or not finite with a drag, a position not finite or
/// beyond `largest_position_m`, or a set larger than the capacity (which also asserts).
class Solver final : public Law {
 public:
  /// Allocates for sets of up to `capacity` [1] primitives. Throws std::bad_alloc.
  explicit Solver(std::size_t capacity = 64);
  ~Solver() override;

  Balance solve(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                double time_step_s) noexcept override;
  std::span<const Vec3> forces_n() const noexcept override { return {forces_.get(), size_}; }
  void reset() noexcept override { size_ = 0; }

  /// [m] Rounding error of the last balance's position_m. The bound was proven at the unrounded position_m + remainder_m(),
  /// then increased by the length of remainder_m().
  const Vec3& remainder_m() const noexcept { return remainder_m_; }

 private:
  class Work;
  void match(std::span<const Primitive> primitives) noexcept;

  std::size_t capacity_;
  std::size_t size_ = 0;
  std::unique_ptr<Vec3[]> forces_;
  std::unique_ptr<PrimitiveId[]> ids_;
  std::unique_ptr<Work> work_;
  Vec3 remainder_m_;
};

/// Balance of a set, by a new Solver; the parameters are those of Law::solve. Allocates; throws std::bad_alloc.
Balance solve_once(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                   double time_step_s);

}  // namespace palpa
