#include "palpa/tick/step_record.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpa/tick/path_tolerances.h"

namespace palpa {

void StepRecord::reserve(std::size_t steps) {
  sub_steps_.reserve(steps);
  placed_.reserve(steps * LocalModel::max_primitives);
}

void StepRecord::clear() noexcept {
  sub_steps_.clear();
  placed_.clear();
}

void StepRecord::add(SubStep& step, bool settles, double spacing_m, const LocalModel& model,
                     const ModeRuntime& modes) noexcept {
  // Straight from its start to its end a sub-step must be the way that the proxy went.
  const bool is_one = settles && !sub_steps_.empty() && sub_steps_.back().stop == Stop::full && step.stop == Stop::full &&
                      distance(step.proxy_m, first_end_m_) <= path_tolerances::piercing * spacing_m;
  if (is_one) {
    step.start_m = sub_steps_.back().start_m;
    step.balance.iterations += sub_steps_.back().balance.iterations;
    placed_.resize(sub_steps_.back().first_primitive);
    sub_steps_.pop_back();
  } else {
    begins_ = !settles;
    first_end_m_ = step.proxy_m;
  }
  const double k = step.stiffness_n_per_m;
  const Vec3& position_m = step.balance.position_m;
  add_rows(step, model, modes);
  const double rounding_m =
      0.5 * std::numeric_limits<double>::epsilon() * (std::abs(position_m.x) + std::abs(position_m.y) + std::abs(position_m.z));
  double held_n = 0.0;
  Vec3 corner_n;  // its facets press together, with one strength
  for (std::size_t i = step.first_primitive; i < placed_.size(); ++i) {
    const PlacedPrimitive& row = placed_[i];
    corner_n += row.force_n;
    if (i + 1 < placed_.size() && placed_[i + 1].primitive.id == row.primitive.id) continue;
    const bool slips = row.state == PrimitiveState::slip;  // in a direction that is known as well as the way is long
    const double share = slips ? std::min(1.0, rounding_m / norm(residual(row.primitive, position_m))) : 1.0;
    // Of a plane, behind it, what the force lacks is wrong, before it all of the force is.
    const double s = row.primitive.strength_n, u = norm(corner_n);
    double moved_n = row.primitive.kind == PrimitiveKind::plane ? std::max(s - u, u) : s + u;
    // Elastic, its force is wrong by no more than its bound and that rounding make it (theory.md 8.12).
    const double stiffness = row.primitive.stiffness_n_per_m;
    if (row.primitive.is_elastic())
      moved_n = std::min(moved_n, std::sqrt(2.0 * stiffness * k) * step.balance.error_bound_m + stiffness * rounding_m);
    if (row.state != PrimitiveState::off) held_n += share * moved_n;
    corner_n = {};
  }
  // The law's bound is that of the balance before its position was rounded. Whoever checks what is recorded by the duality gap
  // pays a root for that rounding where the proxy rests on something, or slips by little.
  // A bound b = (ρ + √(ρ² + 4kε)) / 2k has ρ ≤ kb; with e more of gap it is at most (b + √(b² + 4e/k)) / 2.
  double& bound_m = step.balance.error_bound_m;
  bound_m = 0.5 * (bound_m + std::sqrt(bound_m * bound_m + 4.0 * held_n * rounding_m / k));
  if (step.balance.status == BalanceStatus::exact && bound_m > exact_bound_m) step.balance.status = BalanceStatus::capped;
  const auto energy_j = [&](const Vec3& x) {
    return 0.5 * k * norm_squared(x - step.probe_m) - dot(step.directed_n, x - step.start_m);
  };
  step.energy_before_j = energy_j(step.start_m);
  step.energy_after_j = energy_j(step.proxy_m);
  sub_steps_.push_back(step);
}

// What was solved. Facets without force are left out, which changes nothing (theory.md): at most three are left.
void StepRecord::add_rows(SubStep& step, const LocalModel& model, const ModeRuntime& modes) noexcept {
  const PrimitiveSet& set = model.set();
  const std::span<const Vec3> forces = model.law().forces_n();
  step.first_primitive = static_cast<std::uint32_t>(placed_.size());
  for (std::size_t i = 0; i < set.size(); ++i) {
    const LevelContact* contact = model.contact_of(i);
    Primitive p = set[i];
    if (contact && p.kind == PrimitiveKind::corner) {
      const auto facets = forces.subspan(contact->first, contact->facets);
      const auto pressed = std::count_if(facets.begin(), facets.end(), [](const Vec3& force_n) { return force_n != Vec3{}; });
      if (pressed > 0 ? forces[i] == Vec3{} : i != contact->first) continue;
      if (pressed <= 1) p.kind = PrimitiveKind::plane;
    }
    const Vec3 carried_m = begins_ ? modes.origin_m(p.id.mode) - step.start_m : Vec3{};
    const PrimitiveState state = contact ? contact->state : state_at(set.primitives(), i, step.balance);
    placed_.push_back({p, set.captured(i), forces[i], state, carried_m});
    if (p.kind == PrimitiveKind::directed) step.directed_n += forces[i];
  }
  step.primitives = static_cast<std::uint32_t>(placed_.size()) - step.first_primitive;
}

void StepRecord::book(Ledger& ledger) const noexcept {
  for (const SubStep& step : sub_steps_) {
    double furthest_carried_m = 0.0;
    for (const PlacedPrimitive& row : placed().subspan(step.first_primitive, step.primitives)) {
      ledger.book(row.primitive.id.mode, row.force_n, step.proxy_m - step.start_m, step.move_fraction * row.carried_m);
      if (row.carried_m != Vec3{}) furthest_carried_m = std::max(furthest_carried_m, norm(row.carried_m));
    }
    ledger.move(step.start_m, step.proxy_m, step.balance.position_m, step.probe_m, step.move_fraction * furthest_carried_m);
  }
}

}  // namespace palpa
