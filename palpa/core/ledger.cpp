#include "palpa/core/ledger.h"

#include <cassert>

namespace palpa {

Ledger::Ledger(std::size_t modes) : modes_(modes), works_j_(std::make_unique<double[]>(modes)) {}

void Ledger::begin(const Vec3& proxy_m) noexcept {
  std::fill_n(works_j_.get(), modes_, 0.0);
  start_m_ = proxy_m;
  moved_j_ = 0.0;
}

void Ledger::book(std::size_t mode, const Vec3& force_n, const Vec3& step_m, const Vec3& carried_m) noexcept {
  assert(mode < modes_);
  works_j_[mode] += dot(force_n, step_m - carried_m);
  moved_j_ += dot(force_n, carried_m);
}

Energy Ledger::end(const Vec3& proxy_m, const Vec3& probe_m, double stiffness_n_per_m) noexcept {
  const double k = stiffness_n_per_m;
  Energy energy;
  energy.stored_j = 0.5 * k * norm_squared(proxy_m - probe_m);
  energy.moved_j = moved_j_;
  double sum_j = 0.0;
  for (const double work_j : works_j()) {
    sum_j += work_j;
    (work_j >= 0.0 ? energy.injected_j : energy.dissipated_j) += std::abs(work_j);
  }
  // I = S_m − k/2 |x₀ − p⁺|², written as a product: the difference of squares would lose its digits.
  const double gained_j = k * dot(proxy_m - start_m_, 0.5 * (proxy_m + start_m_) - probe_m);
  energy.path_j = gained_j - sum_j - moved_j_;
  return energy;
}

}  // namespace palpa
