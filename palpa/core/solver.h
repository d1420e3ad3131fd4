// The exact law: dual block sweeps and Newton steps, with a certificate.
#pragma once

#include <memory>

#include "palpa/core/law.h"

namespace palpa {

/// Finds the exact balance by sweeping over the primitives' forces.
///
/// The dual variables of E (see Law) are the primitives' forces u_i; x = p + (d + Σu_i)/k. Holding all
/// forces but one, the best u_i has a closed form: with v = k·r the force that would bring the proxy
/// onto primitive i,
///     |v| ≤ s:  u = v                                       (stick)
///     |v| > s:  u = (s + c/T·ρ) v/|v|,  ρ = (|v| − s)/(k + c/T)   (slip)
/// (a plane: along its normal only, never negative). One sweep over primitives whose spans are mutually
/// orthogonal is exact: a point, a line, a plane, surface with friction (stage 1). Otherwise sweeps repeat,
/// with a few Newton steps of the method of multipliers between two rounds of them (stage 2), until the
/// certificate (`error_bound_m`) is below the tolerance or the cap is reached.
class Solver final : public Law {
 public:
  /// Takes memory for sets of up to `capacity` primitives.
  explicit Solver(std::size_t capacity = 64);

  Balance solve(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                double time_step_s) noexcept override;
  std::span<const Vec3> forces_n() const noexcept override { return {forces_.get(), size_}; }
  void reset() noexcept override { size_ = 0; }

 private:
  std::size_t capacity_;
  std::size_t size_ = 0;
  std::unique_ptr<Vec3[]> forces_;
  std::unique_ptr<PrimitiveId[]> ids_;
  std::unique_ptr<Vec3[]> kept_forces_;
  std::unique_ptr<PrimitiveId[]> kept_ids_;
};

/// The balance of one set, once: a Solver made for the occasion. Allocates.
Balance solve_once(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                   double time_step_s);

}  // namespace palpa
