#include "palpa/session/ledger.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace palpa {

Ledger::Ledger(std::size_t modes, const Tool& tool) : modes_(modes), works_j_(std::make_unique<double[]>(modes)), tool_(tool) {}

void Ledger::begin(const Pose& proxy, const Pose& processed_up_to, std::span<const Contact> contacts) noexcept {
  clear();
  start_ = proxy;
  data_motion_j_ = elastic_j_ = elastic_before_j_ = 0.0;
  probe_ = processed_up_to;
  left_m2_ = released_m2_ = 0.0;
  any_work_ = !contacts.empty();
  for (const Contact& contact : contacts) {
    works_j_[contact.id.mode] -= contact.held_j;
    elastic_before_j_ += contact.held_j;
  }
}

void Ledger::book(std::size_t mode, const Vec3& force_n, const Vec3& step_m, const Vec3& carried_m) noexcept {
  assert(mode < modes_);
  any_work_ = true;
  works_j_[mode] += dot(force_n, step_m - carried_m);
  data_motion_j_ += dot(force_n, carried_m);
}

void Ledger::book_sub_steps(std::span<const SubStep> sub_steps, std::span<const PlacedPrimitive> placed) noexcept {
  for (const SubStep& step : sub_steps) {
    double furthest_carried_m = 0.0;
    const Vec3 way_m = step.proxy_m - step.start_m;
    for (const PlacedPrimitive& row : placed.subspan(step.first_primitive, step.primitives)) {
      book(row.primitive.id.mode, row.force_n, tool_.is_point() ? way_m : foot_way_m(step, row),
           step.move_fraction * row.carried_m);
      if (row.carried_m != Vec3{}) furthest_carried_m = std::max(furthest_carried_m, norm(row.carried_m));
    }
    move(step, step.move_fraction * furthest_carried_m);
  }
}

double Ledger::lost_by_turning_m2(const SubStep& step) const noexcept {
  const Vec3 arc_m = tool_.turning_radius_m() * rotation_between_rad(step.start_turn, step.proxy_turn);
  return 2.0 * dot(arc_m, tool_.turning_radius_m() * step.balance.turn_rad - 0.5 * arc_m);
}

// With the probe fixed, the spring loses k Δx·(probe − middle of the move) and the forces of the balance do the work k
// Δx·(balance − probe). The remainder is k Δx·(balance − middle): k/2 |Δx|² of a full move. Along a smooth path it vanishes
// with the step length; in a snap it is the energy that the spring held. The part beyond the motion of probe and data is a
// snap.
void Ledger::move(const SubStep& step, double carried_m) noexcept {
  const Vec3 &from_m = step.start_m, &to_m = step.proxy_m;
  if (const Pose probe{step.probe_m, step.probe_turn}; !tool_.are_one(probe, probe_)) {
    const Motion step_m = tool_.motion(probe_, probe);
    left_m2_ = tool_.product_m2(step_m, step_m);
    probe_ = probe;
  }
  const double offset_m = std::sqrt(left_m2_) + carried_m;
  double lost_m2 = 2.0 * dot(to_m - from_m, step.balance.position_m - 0.5 * (from_m + to_m));
  if (!tool_.is_point()) lost_m2 += lost_by_turning_m2(step);
  lost_m2 = std::max(0.0, lost_m2);
  const double beyond_m = std::sqrt(lost_m2) - offset_m;
  if (beyond_m > 0.0) released_m2_ += beyond_m * beyond_m;
  left_m2_ = std::max(0.0, offset_m * offset_m - lost_m2);
}

Energy Ledger::end(const Pose& proxy, const Pose& probe, const Motion& probe_step_m, double stiffness_n_per_m,
                   std::span<const SubStep> sub_steps, std::span<const PlacedPrimitive> placed,
                   std::span<const Contact> contacts) noexcept {
  book_sub_steps(sub_steps, placed);
  for (const Contact& contact : contacts) {
    any_work_ = true;
    works_j_[contact.id.mode] += contact.held_j;
    elastic_j_ += contact.held_j;
  }
  const double k = stiffness_n_per_m;
  Energy energy;
  const Motion stretch_m = tool_.motion(probe, proxy);
  energy.stored_j = 0.5 * k * tool_.product_m2(stretch_m, stretch_m);
  energy.elastic_j = elastic_j_;
  energy.data_motion_j = data_motion_j_;
  double sum_j = 0.0;
  for (std::size_t m = 0; any_work_ && m < modes_; ++m) {
    sum_j += works_j_[m];
    (works_j_[m] >= 0.0 ? energy.injected_j : energy.dissipated_j) += std::abs(works_j_[m]);
  }
  // I = S_m − k/2 |x₀ − p⁺|², written as a product: the difference of squares would lose its digits.
  double gained_j =
      k * dot(proxy.position_m - start_.position_m, 0.5 * (proxy.position_m + start_.position_m) - probe.position_m);
  energy.sampling_bound_j = 0.5 * k * norm_squared(probe_step_m.way_m);
  if (!tool_.is_point()) {
    const Vec3 before_m = start_arc_m_, held_m = tool_.motion(probe, start_).arc_m;
    gained_j += 0.5 * k * dot(stretch_m.arc_m - held_m, stretch_m.arc_m + held_m);
    // Of the rotational spring what the held torque misses: at most κ/2 |Δθ|² (theory.md 10.5).
    energy.sampling_bound_j += 0.5 * k * dot(held_m - before_m, held_m + before_m) + k * dot(before_m, probe_step_m.arc_m);
  }
  energy.path_and_release_j = gained_j - sum_j + (elastic_j_ - elastic_before_j_) - data_motion_j_;
  energy.released_j = 0.5 * k * released_m2_;
  energy.sampling_j = energy.path_and_release_j + energy.sampling_bound_j + energy.released_j;
  return energy;
}

}  // namespace palpa
