#include "palpa/mode/vortex.h"

#include "palpa/mode/placement.h"

namespace palpa {

namespace {

constexpr std::uint16_t tube_slot = 0;

constexpr double threshold_share = 0.05;  // of the largest Q: below, Q of measured data is noise

/// The strength at this place, given what it is without regard to the vortex.
double in_vortex_n(const Here& here, const FieldRef& field, bool everywhere, double strength_n) noexcept {
  const ScalarSample& q = here.scalar(field);
  const double steepness = norm(q.gradient);
  if (!q.inside || !(steepness > 0.0)) return 0.0;
  const double steady_n = detail::steady_strength_n(here.stiffness_n_per_m, steepness, here.hessian(field));
  if (everywhere) return std::min(strength_n, steady_n);
  const double depth = q.value - threshold_share * std::max(0.0, here.range(field).max);
  return depth > 0.0 ? std::min({strength_n, steady_n, 0.5 * here.stiffness_n_per_m * depth / steepness}) : 0.0;
}

}  // namespace

void VortexForce::place(const Here& here, PrimitiveSet& out) const noexcept {
  const double strength = in_vortex_n(here, field, !strength_n.is_constant(), here.newtons(strength_n));
  if (strength > 0.0) out.directed(0, normalized(here.scalar(field).gradient), strength);
}

void VortexPlane::place(const Here& here, const Memory& memory, PrimitiveSet& out) const noexcept {
  const ScalarSample& q = here.scalar(field);
  const Captured level{field.index, memory.captured ? memory.value : q.value};
  const double strength =
      in_vortex_n(here, field, !strength_n.is_constant(), here.newtons(strength_n, level, TransferFunction::Side::above));
  if (!(strength > 0.0)) return;
  out.plane(tube_slot, detail::foot_on_level_m(here, q, level.value), normalized(q.gradient), strength, level);
}

void VortexPlane::settle(const Settled& settled, Memory& memory) const noexcept {
  const PrimitiveState state = settled.state(tube_slot);
  memory.captured = settled.placed(tube_slot) && state != PrimitiveState::off;
  if (state == PrimitiveState::slip) memory.value = settled.here.scalar(field).value;  // pulled outwards
  if (state == PrimitiveState::stick) memory.value = settled.slots.front().captured.value;
}

}  // namespace palpa
