#include "palpa/solver/coulomb_friction.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace palpa {

namespace {

// [1] of its strength: a line whose force is below this share sticks. 1: rounding decides; less: more lines are corrected in
// vain, at a balance each.
constexpr double holding_share = 0.999;

// Friction strength of a line, from the force of its plane or of its corner's facets in the last balance [N].
double wanted_n(std::span<const Vec3> loads_n, const PrimitiveSet& set, const Friction& friction) noexcept {
  double pressed_n = 0.0;
  const std::size_t plane = set.row(static_cast<std::size_t>(friction.plane));
  for (std::size_t i = plane; i < set.size() && set[i].id == set[plane].id; ++i) pressed_n += norm(loads_n[i]);
  return friction.coefficient * pressed_n;
}

// Force of a plane on which only lines along its normal and directed forces act [N]: the lines act across it, so it is known
// before the balance. None for other planes.
std::optional<double> pressed_alone_n(const PrimitiveSet& set, std::size_t plane, const Vec3& probe_m,
                                      double stiffness_n_per_m) {
  const Primitive& p = set[plane];
  Vec3 pull_n = stiffness_n_per_m * (probe_m - p.position_m);
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (set[i].kind == PrimitiveKind::directed) {
      pull_n += set[i].strength_n * set[i].direction;
    } else if (i != plane && (set[i].kind != PrimitiveKind::line || set[i].direction != p.direction)) {
      return {};
    }
  }
  if (p.kind != PrimitiveKind::plane || p.drag_ns_per_m > 0.0) return {};
  // An elastic plane yields: plane and spring share the pull.
  return std::clamp(-dot(p.direction, pull_n) / (1.0 + stiffness_n_per_m / p.stiffness_n_per_m), 0.0, p.strength_n);
}

}  // namespace

CoulombFriction::CoulombFriction(StateArena& live, std::size_t capacity)
    : known_(live.add<std::size_t>()), last_(live.add<Line>(capacity)) {
  lines_.reserve(capacity);
}

Balance CoulombFriction::solve(ToolLaw& law, PrimitiveSet& set, const Pose& probe, double stiffness_n_per_m, double time_step_s,
                               int most_iterations) noexcept {
  lines_.clear();
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (!set.friction_of(i).any()) continue;
    const PrimitiveId& id = set[i].id;
    const Friction& friction = set.friction_of(i);
    const std::size_t plane = set.row(static_cast<std::size_t>(friction.plane));
    const auto alone_n =
        law.tool().is_point() ? pressed_alone_n(set, plane, probe.position_m, stiffness_n_per_m) : std::nullopt;
    const auto last = last_.first(known_);
    const auto before = std::ranges::find(last, id, &Line::id);
    lines_.push_back(before == last.end() ? Line{id, i} : Line{id, i, before->strength_n, before->slope});
    if (alone_n) lines_.back().strength_n = friction.coefficient * *alone_n;
    set.set_strength(i, lines_.back().strength_n);
  }
  const auto balance = [&] { return law.solve(set, probe, stiffness_n_per_m, time_step_s); };
  Balance found = balance();
  if (lines_.empty()) return found;
  const double tolerance_n = exact_bound_m * stiffness_n_per_m;
  for (int pass = 0; pass < max_passes && found.iterations < most_iterations; ++pass) {
    bool changed = false;
    const std::span<const Vec3> loads_n = law.loads_n(set, found);
    for (Line& line : lines_) {
      changed = correct(line, wanted_n(loads_n, set, set.friction_of(line.index)), norm(law.forces_n()[line.index]),
                        tolerance_n, pass == 0) ||
                changed;
      set.set_strength(line.index, line.strength_n);
    }
    if (!changed) break;
    const int iterations = found.iterations;
    found = balance();
    found.iterations += iterations;
  }
  std::ranges::copy(lines_, last_.begin());
  known_ = lines_.size();
  return found;
}

// Sets the next trial strength of a line. False if the balance is unchanged.
bool CoulombFriction::correct(Line& line, double wanted_n, double held_n, double tolerance_n, bool first) const noexcept {
  const double off_n = wanted_n - line.strength_n;
  const double step_n = line.strength_n - line.before_n;
  if (!first && step_n != 0.0) line.slope = std::clamp((wanted_n - line.wanted_n) / step_n, -1.0, 0.5);
  // A line that sticks does so at any strength above its force: the balance is unchanged.
  if (held_n < std::min(wanted_n, holding_share * line.strength_n)) {
    line.strength_n = wanted_n;
    return false;
  }
  if (std::abs(off_n) <= tolerance_n) return false;
  line.before_n = line.strength_n;
  line.wanted_n = wanted_n;
  line.strength_n = std::max(0.0, line.strength_n + off_n / (1.0 - line.slope));
  return true;
}

}  // namespace palpa
