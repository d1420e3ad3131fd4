#include "palpa/session/directed_force_limiter.h"

#include <algorithm>

namespace palpa {

namespace {

// [1] Share of the forces. Less: rounding is reported as limited; more: steps may exceed the limit.
constexpr double rounding = 1e-12;

Vec3 force_of(const Primitive& p) noexcept { return p.strength_n * p.direction; }

}  // namespace

void DirectedForceLimiter::clear() noexcept { last_ = {}; }

std::int32_t DirectedForceLimiter::hold_back(PrimitiveSet& set, const Pose& at, const ToolLaw& law, double stiffness_n_per_m,
                                             double moved_n) const noexcept {
  const auto is_directed = [](const Primitive& p) { return p.kind == PrimitiveKind::directed; };
  if (!last_.any || (held().empty() && std::ranges::none_of(set.primitives(), is_directed))) return -1;
  const auto is_placed = [&](const Force& before) {
    for (const Primitive& p : set.primitives()) {
      if (p.kind == PrimitiveKind::directed && p.id == before.id) return true;
    }
    return false;
  };
  // The force of a mode that places none any more decreases along the path within the limit.
  for (const Force& before : held()) {
    if (before.force_n == Vec3{} || is_placed(before)) continue;
    set.begin_foot(before.id.foot, set.start_m());
    set.begin_mode(before.id.mode);
    set.directed(before.id.slot, normalized(before.force_n), 0.0);
  }
  const auto held_n = [&](const PrimitiveId& id) {
    const auto before = std::ranges::find(held(), id, &Force::id);
    return before == held().end() ? Vec3{} : before->force_n;
  };

  Motion change_n;  // of the wrench, torques divided by the turning radius
  const Tool& tool = law.tool();
  double all_n = 0.0;
  double largest_n = 0.0;
  std::int32_t fastest = 0;
  for (const Primitive& p : set.primitives()) {
    if (p.kind != PrimitiveKind::directed) continue;
    const Vec3 one_n = force_of(p) - held_n(p.id);
    change_n.way_m += one_n;
    if (!tool.is_point()) change_n.arc_m += cross(law.lever_m(p.id), one_n) / tool.turning_radius_m();
    all_n += p.strength_n;
    if (const double size_n = norm(one_n); size_n > largest_n) {
      largest_n = size_n;
      fastest = p.id.mode;
    }
  }
  const double most_n = 0.5 * stiffness_n_per_m * tool.length_m(last_.at, at) + moved_n;
  const double changed_n = tool.is_point() ? norm(change_n.way_m) : length(change_n);
  if (changed_n <= most_n + rounding * all_n) return -1;

  const double share = most_n / changed_n;
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (set[i].kind != PrimitiveKind::directed) continue;
    const Vec3 before_n = held_n(set[i].id);
    set.set_directed(i, before_n + share * (force_of(set[i]) - before_n));
  }
  return fastest;
}

void DirectedForceLimiter::keep(const PrimitiveSet& set, const Pose& at) noexcept {
  last_ = {.at = at, .any = true};
  for (const Primitive& p : set.primitives()) {
    if (p.kind == PrimitiveKind::directed && last_.size < forces_.size()) forces_[last_.size++] = {p.id, force_of(p)};
  }
}

}  // namespace palpa
