// Modes that place a single primitive.
#include "palpa/mode/modes.h"
#include "palpa/mode/placement.h"
#include "palpa/mode/vortex_core.h"

namespace palpa {

void Follow::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const VectorSample sample = here.vector(field);
  if (!sample.inside || sample.value == Vec3{}) return;
  out.line(0, here.proxy_m, normalized(sample.value), here.newtons(strength_n), here.drag(drag_ns_per_m));
}

void FrontShape::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const VectorSample sample = here.vector(field);
  if (!sample.inside || sample.value == Vec3{}) return;
  out.plane(0, here.proxy_m, normalized(sample.value), here.newtons(strength_n), {}, here.drag(drag_ns_per_m));
}

void GradientForce::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const Mat3 hessian = here.hessian(field);
  const ScalarSample sample = here.scalar(field);
  const double steepness = norm(sample.gradient);
  if (!sample.inside || !(steepness > 0.0)) return;
  const double steady_n = detail::steady_strength_n(here.stiffness_n_per_m, steepness, hessian);
  const Vec3 uphill = normalized(sample.gradient);
  const double weight = detail::gradient_weight(here, sample.gradient, noise_per_m);
  out.directed(0, towards == Towards::high ? uphill : -uphill, weight * std::min(here.newtons(strength_n), steady_n));
}

std::string TransverseDamping::problem() const {
  const bool silent = strength_n.is_constant() && strength_n.constant_n == 0.0 && drag_ns_per_m == 0.0;
  return silent ? "drag_ns_per_m and strength_n are both 0; give one of them" : "";
}

void TransverseDamping::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const VectorSample sample = here.vector(field);
  if (!sample.inside || sample.value == Vec3{}) return;
  out.line(0, here.proxy_m, normalized(sample.value), here.newtons(strength_n), here.drag(drag_ns_per_m));
}

void VectorForce::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const VectorSample sample = here.vector(field);
  const double speed = norm(sample.value);
  if (!sample.inside || !(speed > 0.0)) return;
  const double steady_n = detail::steady_strength_n(here.stiffness_n_per_m, speed, sample.jacobian);
  out.directed(0, normalized(sample.value), std::min(here.newtons(strength_n), steady_n));
}

std::string Viscosity::problem() const {
  const bool silent = strength_n.is_constant() && strength_n.constant_n == 0.0 && drag_ns_per_m == 0.0;
  return silent ? "neither strength_n nor drag_ns_per_m is given; give one of them" : "";
}

void Viscosity::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  out.point(0, here.proxy_m, here.newtons(strength_n), here.drag(drag_ns_per_m));
}

std::string VortexLine::problem() const {
  return background != Vec3{} && direction == By::q
             ? "a background is given, and direction = \"q\" is the same whatever moves along; leave it out"
             : "";
}

void VortexLine::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const VectorSample u = here.companion_vector(field);
  const Mat3 hessian = direction == By::q ? here.hessian(field) : Mat3{};
  const detail::CoreLine core = direction == By::q ? detail::core_by_q(here.scalar(field), hessian, u)
                                                   : detail::core_by_velocity(u, here.direction_to_hand(background));
  const double strength = core.trust * detail::in_vortex_n(here, field, !strength_n.is_constant(), here.newtons(strength_n));
  const Vec3 core_m = here.at_m + core.offset_m;
  const bool is_within_reach = largest_component(core_m) <= largest_position_m;  // a core further away is ignored
  if (strength > 0.0 && is_within_reach) out.line(0, core_m, core.axis, strength);
}

}  // namespace palpa
