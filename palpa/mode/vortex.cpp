#include "palpa/mode/modes.h"
#include "palpa/mode/placement.h"
#include "palpa/mode/vortex_core.h"

namespace palpa {

namespace {

constexpr std::uint16_t tube_slot = 0;

// Path to the core by the mode's method.
struct ToCore {
  Vec3 direction;         // [1] unit length, or zero
  double steady_n = 0.0;  // largest force along it that turns by no more than k/2 per metre
};

ToCore by_q(const ModeContext& here, const FieldRef& field) noexcept {
  const Mat3 hessian = here.hessian(field);
  const ScalarSample q = here.scalar(field);
  const double steepness = norm(q.gradient);
  if (!q.inside || !(steepness > 0.0)) return {};
  return {normalized(q.gradient), detail::steady_strength_n(here.stiffness_n_per_m, steepness, hessian)};
}

ToCore by_vorticity(const ModeContext& here, const VectorSample& u, const Vec3& background) noexcept {
  if (!u.inside) return {};
  const Mat3& j = u.jacobian;
  const Vec3 axis = normalized({j.row[2].y - j.row[1].z, j.row[0].z - j.row[2].x, j.row[1].x - j.row[0].y});
  const Vec3 inwards = cross(axis, u.value - background);
  if (inwards == Vec3{}) return {};
  return {normalized(inwards), detail::steady_strength_n(here.stiffness_n_per_m, norm(inwards), j)};
}

ToCore by_reduced_velocity(const ModeContext& here, const VectorSample& u, const Vec3& background) noexcept {
  const detail::CoreLine core = detail::core_by_velocity(u, background);
  return {normalized(core.offset_m), core.trust * 0.5 * here.stiffness_n_per_m * norm(core.offset_m)};
}

template <class M>
ToCore to_core(const ModeContext& here, const M& mode) noexcept {
  if (mode.direction == VortexDirection::q) return by_q(here, mode.field);
  const Vec3 background = here.direction_to_hand(mode.background);
  const VectorSample u = here.companion_vector(mode.field);
  return mode.direction == VortexDirection::vorticity ? by_vorticity(here, u, background)
                                                      : by_reduced_velocity(here, u, background);
}

template <class M>
double in_vortex_n(const ModeContext& here, const M& mode, double strength_n) noexcept {
  return detail::in_vortex_n(here, mode.field, !mode.strength_n.is_constant(), strength_n);
}

template <class M>
std::string problem_of(const M& mode) {
  return mode.background != Vec3{} && mode.direction == VortexDirection::q
             ? "a background is given, and direction = \"q\" is the same whatever moves along; leave it out"
             : "";
}

}  // namespace

std::string VortexForce::problem() const { return problem_of(*this); }
std::string VortexPlane::problem() const { return problem_of(*this); }

void VortexForce::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const ToCore core = to_core(here, *this);
  const double strength = std::min(in_vortex_n(here, *this, here.newtons(strength_n)), core.steady_n);
  if (strength > 0.0) out.directed(0, core.direction, strength);
}

void VortexPlane::place(const ModeContext& here, const Memory& memory, PrimitiveSink out) const noexcept {
  const ToCore core = to_core(here, *this);
  if (core.direction == Vec3{}) return;
  const bool on_level = direction == VortexDirection::q;
  const ScalarSample q = here.scalar(field);
  HeldLevel level =
      on_level ? HeldLevel{here.number_of(field), memory.stays ? memory.value : here.value_at_start(field)} : HeldLevel{};
  const LevelStrength bears = here.newtons(strength_n, level, TransferFunction::Side::above);
  level.limited = bears.limited;
  level.goes_along = on_level;
  const double strength = std::min(in_vortex_n(here, *this, bears.newtons), core.steady_n);
  if (!(strength > 0.0)) return;
  out.plane(tube_slot, on_level ? detail::nearest_on_level_m(here, here.at_m, q, level.value) : here.proxy_m, core.direction,
            strength, level);
}

void VortexPlane::on_step_accepted(const StepResult& result, Memory& memory) const noexcept {
  const PrimitiveState state = result.state(tube_slot);
  memory.stays = direction == VortexDirection::q && result.placed(tube_slot) && state != PrimitiveState::off;
  if (state == PrimitiveState::slip) memory.value = result.here.scalar(field).value;  // pulled outwards
  if (state == PrimitiveState::stick) memory.value = result.contacts.front().level.value;
}

}  // namespace palpa
