// The exact law: dual sweeps, a stick/slip active set and a method of multipliers, each with its proof.
#pragma once

#include <memory>

#include "palpa/solver/law.h"

namespace palpa {

/// Finds the exact balance, and proves it.
///
/// The dual variables of E (see Law) are the primitives' forces u; x = probe + (directed + Σu)/k. Three
/// stages follow each other until the duality gap proves that the balance is found; the derivations stand
/// above each in solver.cpp, the theory in docs/theory.md:
///   1. sweeps: each force in turn becomes the best one, all others held. One sweep is the closed form of
///      mutually orthogonal primitives, and points among others at one anchor are added in closed form.
///      A single primitive and a surface with its friction end here, with rounding as their only bound, and so does
///      a corner of which one facet holds;
///   2. active set: which primitives stick and which slip is taken from the forces, the balance of that
///      choice comes from a 3×3 system, and it says who sticks and slips next;
///   3. multipliers: the fallback, convergent from anywhere but for its cap.
/// All counts are capped; at the cap the best balance met is returned with its bound. The answer is `bad_input`, with the start
/// as position and zero forces, where k is outside of 1e-12 to 1e12 N/m, T <= 0 or not finite although there is a drag, a
/// position not finite or beyond `largest_position_m`, or the set larger than the capacity (which also asserts).
class Solver final : public Law {
 public:
  /// Takes memory for sets of up to `capacity` primitives. Throws std::bad_alloc.
  explicit Solver(std::size_t capacity = 64);
  ~Solver() override;

  Balance solve(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                double time_step_s) noexcept override;
  std::span<const Vec3> forces_n() const noexcept override { return {forces_.get(), size_}; }
  void reset() noexcept override { size_ = 0; }

  /// [m] What position_m of the last balance lost by rounding to doubles: the bound was proven at position_m + remainder_m(), a
  /// sum that is finer than a double, and then widened by the remainder.
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

/// The balance of one set, by a new Solver; the parameters are those of Law::solve. Allocates; throws std::bad_alloc.
Balance solve_once(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                   double time_step_s);

}  // namespace palpa
