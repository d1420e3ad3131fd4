#include "palpa/mode/vortex.h"

#include "palpa/mode/placement.h"

namespace palpa {

namespace {

constexpr std::uint16_t tube_slot = 0;

/// The strength within the vortex: not more than k/2 × the depth below its edge, nor than turning allows.
double strength_in_vortex_n(const Here& here, const FieldRef& field, const Strength& strength,
                            double threshold_share) noexcept {
  const ScalarSample& q = here.scalar(field);
  const double steepness = norm(q.gradient);
  const double edge = threshold_share * std::max(0.0, here.range(field).max);
  if (!q.inside || !(steepness > 0.0) || !(q.value > edge)) return 0.0;
  const double fade_n = 0.5 * here.stiffness_n_per_m * (q.value - edge) / steepness;
  const double steady_n = detail::steady_strength_n(here.stiffness_n_per_m, steepness, here.hessian(field));
  return std::min({here.newtons(strength), fade_n, steady_n});
}

}  // namespace

void VortexForce::place(const Here& here, PrimitiveSet& out) const noexcept {
  const double strength = strength_in_vortex_n(here, field, strength_n, threshold_share);
  if (strength > 0.0) out.directed(0, normalized(here.scalar(field).gradient), strength);
}

void VortexPlane::place(const Here& here, const Memory& memory, PrimitiveSet& out) const noexcept {
  const double strength = strength_in_vortex_n(here, field, strength_n, threshold_share);
  if (!(strength > 0.0)) return;
  const ScalarSample& q = here.scalar(field);
  const double level = memory.captured ? memory.value : q.value;
  out.plane(tube_slot, detail::foot_on_level_m(here, q, level), normalized(q.gradient), strength, {field.index, level});
}

void VortexPlane::settle(const Settled& settled, Memory& memory) const noexcept {
  const PrimitiveState state = settled.state(tube_slot);
  memory.captured = settled.placed(tube_slot) && state != PrimitiveState::off;
  if (state == PrimitiveState::slip) memory.value = settled.here.scalar(field).value;  // pulled outwards
  if (state == PrimitiveState::stick) memory.value = settled.slots.front().captured.value;
}

}  // namespace palpa
