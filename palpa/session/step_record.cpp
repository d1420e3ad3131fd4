#include "palpa/session/step_record.h"

#include <algorithm>

#include "palpa/session/path_tolerances.h"
#include "palpa/session/sub_step.h"

namespace palpa {

void StepRecord::reserve(std::size_t steps, std::size_t feet) {
  sub_steps_.resize(std::max(steps, sub_steps_.size()));
  placed_.reserve(steps * ContactProblem::most_primitives(feet));
}

void StepRecord::clear() noexcept {
  size_ = 0;
  placed_.clear();
}

void StepRecord::end(bool settles, double spacing_m, const ContactProblem& model, const ModeRuntime& modes) noexcept {
  SubStep& step = sub_steps_[size_ - 1];
  SubStep* const before = size_ > 1 ? &sub_steps_[size_ - 2] : nullptr;
  // A recorded sub-step is a straight path: only moves near the first move's end are joined. A tool's levers and rotation are
  // those at the start of a move: each of its balances is verifiable by itself alone.
  const bool is_one = modes.tool().is_point() && settles && before && before->stop == Stop::full && step.stop == Stop::full &&
                      distance(step.proxy_m, first_end_m_) <= path_tolerances::piercing * spacing_m;
  if (is_one) {
    step.start_m = before->start_m;
    step.balance.iterations += before->balance.iterations;
    placed_.resize(before->first_primitive);
  } else {
    begins_ = !settles;
    first_end_m_ = step.proxy_m;
  }
  step.directed_n = {};
  step.first_primitive = static_cast<std::uint32_t>(placed_.size());
  step.primitives = 0;
  if (!model.set().empty()) add_rows(step, model, modes);
  complete(step, placed().last(step.primitives));
  if (!is_one) return;
  *before = step;
  --size_;
}

// Leaves out facets without force, which changes nothing (theory.md); at most three have one.
void StepRecord::add_rows(SubStep& step, const ContactProblem& model, const ModeRuntime& modes) noexcept {
  const PrimitiveSet& set = model.set();
  const Tool& tool = modes.tool();
  const std::span<const Vec3> forces = model.law().forces_n();
  const Pose start{step.start_m, step.start_turn};
  auto next = model.contacts().begin();  // in the order of their rows
  for (std::size_t i = 0; i < set.size(); ++i) {
    while (next != model.contacts().end() && set.row(next->plane) + next->facets <= i) ++next;
    const LevelContact* contact = next != model.contacts().end() && set.row(next->plane) <= i ? &*next : nullptr;
    const Primitive& p = set[i];
    PrimitiveKind kind = p.kind;
    if (contact && p.kind == PrimitiveKind::corner) {
      const std::size_t first = set.row(contact->plane);
      const auto facets = forces.subspan(first, contact->facets);
      const auto pressed = std::count_if(facets.begin(), facets.end(), [](const Vec3& force_n) { return force_n != Vec3{}; });
      if (pressed > 0 ? forces[i] == Vec3{} : i != first) continue;
      if (pressed <= 1) kind = PrimitiveKind::plane;
    }
    const Vec3 carried_m = begins_ ? modes.origin_m(p.id) - tool.foot_m(start, p.id.foot) : Vec3{};
    const PrimitiveState state =
        contact ? contact->state
                : model.law().at_foot(step.balance, p.id, [&](const Balance& at) { return state_at(set.primitives(), i, at); });
    const Friction& friction = set.friction_of(i);
    const std::int32_t plane_slot = friction.any() ? set[set.row(static_cast<std::size_t>(friction.plane))].id.slot : -1;
    const HeldLevel& level = set.captured(i);
    const bool rides = level.any() ? level.goes_along : kind != PrimitiveKind::directed && p.position_m == modes.origin_m(p.id);
    placed_.emplace_back(p, set.captured(i), forces[i], state, carried_m, tool.lever_m(step.start_turn, p.id.foot),
                         friction.coefficient, plane_slot, rides);
    placed_.back().primitive.kind = kind;
    if (kind == PrimitiveKind::directed) step.directed_n += forces[i];
  }
  step.primitives = static_cast<std::uint32_t>(placed_.size()) - step.first_primitive;
}

}  // namespace palpa
