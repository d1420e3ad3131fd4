#include "palpa/mode/modes.h"
#include "palpa/mode/vortex_core.h"

namespace palpa {

std::string VortexLine::problem() const {
  return background != Vec3{} && direction == By::q
             ? "a background is given, and direction = \"q\" is the same whatever moves along; leave it out"
             : "";
}

void VortexLine::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const VectorSample& u = here.vector(velocity);
  const detail::CoreLine core = direction == By::q ? detail::core_by_q(here.scalar(field), here.hessian(field), u)
                                                   : detail::core_by_velocity(u, here.turned_to_hand(background));
  const double strength = core.trust * detail::in_vortex_n(here, field, !strength_n.is_constant(), here.newtons(strength_n));
  if (strength > 0.0) out.line(0, here.at_m + core.offset_m, core.axis, strength);
}

}  // namespace palpa
