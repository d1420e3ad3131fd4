#include "palpa/mode/modes.h"
#include "palpa/mode/vortex_core.h"

namespace palpa {

std::string VortexLine::problem() const {
  return background != Vec3{} && direction == By::q
             ? "a background is given, and direction = \"q\" is the same whatever moves along; leave it out"
             : "";
}

void VortexLine::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const VectorSample u = here.vector(velocity);
  const detail::CoreLine core = direction == By::q ? detail::core_by_q(here.scalar(field), here.hessian(field), u)
                                                   : detail::core_by_velocity(u, here.direction_to_hand(background));
  const double strength = core.trust * detail::in_vortex_n(here, field, !strength_n.is_constant(), here.newtons(strength_n));
  const Vec3 core_m = here.at_m + core.offset_m;
  const bool is_within_reach = largest_component(core_m) <= largest_position_m;  // a core further away than that is none
  if (strength > 0.0 && is_within_reach) out.line(0, core_m, core.axis, strength);
}

}  // namespace palpa
