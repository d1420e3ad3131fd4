// Exact law: dual sweeps, a stick/slip active set and a method of multipliers, each with its proof.
#pragma once

#include <memory>

#include "palpa/solver/law.h"

namespace palpa {

/// Finds the exact balance, and proves it.
///
/// The dual variables of E (see Law) are the primitives' forces u; x = probe + (directed + Σu)/k. Three stages run in order
/// until the duality gap proves the balance; the derivations stand above each in solver.cpp, the theory in docs/theory.md:
///   1. sweeps: each force in turn becomes optimal, all others held. One sweep is the closed form of
///      mutually orthogonal primitives, and points with a common anchor are added in closed form.
///      A single primitive and a surface with its friction end here, with rounding as their only bound, and so does
///      a corner with a single holding facet;
///   2. active set: the forces give the sticking and slipping primitives, the balance of that choice comes from a
///      3×3 system, and gives the next choice;
///   3. multipliers: the fallback, convergent from anywhere but for its cap.
/// All counts are capped; at the cap the best balance so far is returned with its bound. Returns `bad_input`, with the start as
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

  /// [m] Rounding of the last balance's position_m: the bound was proven at position_m + remainder_m(), a sum finer than a
  /// double, and then widened by the remainder.
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
