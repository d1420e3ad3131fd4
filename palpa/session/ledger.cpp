#include "palpa/session/ledger.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace palpa {

Ledger::Ledger(std::size_t modes) : modes_(modes), works_j_(std::make_unique<double[]>(modes)) {}

void Ledger::begin(const Vec3& proxy_m, const Vec3& processed_up_to_m, std::span<const Contact> contacts) noexcept {
  std::fill_n(works_j_.get(), modes_, 0.0);
  start_m_ = proxy_m;
  data_motion_j_ = elastic_j_ = elastic_before_j_ = 0.0;
  probe_m_ = processed_up_to_m;
  left_m2_ = released_m2_ = 0.0;
  for (const Contact& contact : contacts) {
    works_j_[contact.id.mode] -= contact.held_j;
    elastic_before_j_ += contact.held_j;
  }
}

void Ledger::book(std::size_t mode, const Vec3& force_n, const Vec3& step_m, const Vec3& carried_m) noexcept {
  assert(mode < modes_);
  works_j_[mode] += dot(force_n, step_m - carried_m);
  data_motion_j_ += dot(force_n, carried_m);
}

void Ledger::book_sub_steps(std::span<const SubStep> sub_steps, std::span<const PlacedPrimitive> placed) noexcept {
  for (const SubStep& step : sub_steps) {
    double furthest_carried_m = 0.0;
    for (const PlacedPrimitive& row : placed.subspan(step.first_primitive, step.primitives)) {
      book(row.primitive.id.mode, row.force_n, step.proxy_m - step.start_m, step.move_fraction * row.carried_m);
      if (row.carried_m != Vec3{}) furthest_carried_m = std::max(furthest_carried_m, norm(row.carried_m));
    }
    move(step.start_m, step.proxy_m, step.balance.position_m, step.probe_m, step.move_fraction * furthest_carried_m);
  }
}

// With the probe fixed, the spring loses k Δx·(probe − middle of the move) and the forces of the balance do the work k
// Δx·(balance − probe). The remainder is k Δx·(balance − middle): k/2 |Δx|² of a full move. Along a smooth path it vanishes
// with the step length; in a snap it is the energy that the spring held. The part beyond the motion of probe and data is a
// snap.
void Ledger::move(const Vec3& from_m, const Vec3& to_m, const Vec3& balance_m, const Vec3& probe_m, double carried_m) noexcept {
  if (probe_m != probe_m_) left_m2_ = norm_squared(probe_m - probe_m_);
  probe_m_ = probe_m;
  const double offset_m = std::sqrt(left_m2_) + carried_m;
  const double lost_m2 = std::max(0.0, 2.0 * dot(to_m - from_m, balance_m - 0.5 * (from_m + to_m)));
  const double beyond_m = std::sqrt(lost_m2) - offset_m;
  if (beyond_m > 0.0) released_m2_ += beyond_m * beyond_m;
  left_m2_ = std::max(0.0, offset_m * offset_m - lost_m2);
}

Energy Ledger::end(const Vec3& proxy_m, const Vec3& probe_m, const Vec3& probe_step_m, double stiffness_n_per_m,
                   std::span<const SubStep> sub_steps, std::span<const PlacedPrimitive> placed,
                   std::span<const Contact> contacts) noexcept {
  book_sub_steps(sub_steps, placed);
  for (const Contact& contact : contacts) {
    works_j_[contact.id.mode] += contact.held_j;
    elastic_j_ += contact.held_j;
  }
  const double k = stiffness_n_per_m;
  Energy energy;
  energy.stored_j = 0.5 * k * norm_squared(proxy_m - probe_m);
  energy.elastic_j = elastic_j_;
  energy.data_motion_j = data_motion_j_;
  double sum_j = 0.0;
  for (const double work_j : works_j()) {
    sum_j += work_j;
    (work_j >= 0.0 ? energy.injected_j : energy.dissipated_j) += std::abs(work_j);
  }
  // I = S_m − k/2 |x₀ − p⁺|², written as a product: the difference of squares would lose its digits.
  const double gained_j = k * dot(proxy_m - start_m_, 0.5 * (proxy_m + start_m_) - probe_m);
  energy.path_and_release_j = gained_j - sum_j + (elastic_j_ - elastic_before_j_) - data_motion_j_;
  energy.released_j = 0.5 * k * released_m2_;
  energy.sampling_bound_j = 0.5 * k * norm_squared(probe_step_m);
  energy.sampling_j = energy.path_and_release_j + energy.sampling_bound_j + energy.released_j;
  return energy;
}

}  // namespace palpa
