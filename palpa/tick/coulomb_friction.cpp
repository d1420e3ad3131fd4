#include "palpa/tick/coulomb_friction.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpa {

namespace {

constexpr double holding_share = 0.999;  // of its strength: a line with less force than this holds the proxy

// How strong the friction of a line is by the forces of its plane, or planes, in the last balance [N].
double wanted_by_plane_n(const Law& law, const PrimitiveSet& set, std::size_t own, const Friction& friction) noexcept {
  const auto plane = static_cast<std::size_t>(friction.plane);
  double pressed_n = norm(law.forces_n()[plane]);
  for (std::size_t j = own; j < set.size(); ++j) {
    if (set[j].id.mode == set[plane].id.mode && set.captured(j) == set.captured(plane)) pressed_n += norm(law.forces_n()[j]);
  }
  return friction.coefficient * pressed_n;
}

}  // namespace

CoulombFriction::CoulombFriction(std::size_t capacity) {
  last_.reserve(capacity);
  lines_.reserve(capacity);
}

Balance CoulombFriction::solve(Law& law, PrimitiveSet& set, std::size_t own, const Vec3& probe_m, double stiffness_n_per_m,
                               double time_step_s) noexcept {
  lines_.clear();
  for (std::size_t i = 0; i < own; ++i) {
    if (!set.friction_of(i).any()) continue;
    const PrimitiveId& id = set[i].id;
    const auto before = std::find_if(last_.begin(), last_.end(), [&](const Line& line) { return line.id == id; });
    lines_.push_back(before == last_.end() ? Line{id, i} : Line{id, i, before->strength_n, before->slope});
    set.set_strength(i, lines_.back().strength_n);
  }
  const auto balance = [&] { return law.solve(set, set.start_m(), probe_m, stiffness_n_per_m, time_step_s); };
  Balance found = balance();
  if (lines_.empty()) return found;
  const double tolerance_n = exact_bound_m * stiffness_n_per_m;
  for (int pass = 0; pass < max_passes; ++pass) {
    bool changed = false;
    for (Line& line : lines_) {
      const double wanted_n = wanted_by_plane_n(law, set, own, set.friction_of(line.index));
      changed = correct(line, wanted_n, norm(law.forces_n()[line.index]), tolerance_n, pass == 0) || changed;
      set.set_strength(line.index, line.strength_n);
    }
    if (!changed) break;
    const int iterations = found.iterations;
    found = balance();
    found.iterations += iterations;
  }
  std::swap(last_, lines_);
  return found;
}

// Gives a line the strength to try next. False where the balance stays as it is.
bool CoulombFriction::correct(Line& line, double wanted_n, double held_n, double tolerance_n, bool first) const noexcept {
  const double off_n = wanted_n - line.strength_n;
  const double step_n = line.strength_n - line.before_n;
  if (!first && step_n != 0.0) line.slope = std::clamp((wanted_n - line.wanted_n) / step_n, -1.0, 0.5);
  // What holds the proxy holds it with any strength above its force.
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
