#include "palpa/mode/modes.h"
#include "palpa/mode/placement.h"

namespace palpa {

void VectorForce::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const VectorSample sample = here.vector(field);
  const double speed = norm(sample.value);
  if (!sample.inside || !(speed > 0.0)) return;
  const double steady_n = detail::steady_strength_n(here.stiffness_n_per_m, speed, sample.jacobian);
  out.directed(0, normalized(sample.value), std::min(here.newtons(strength_n), steady_n));
}

}  // namespace palpa
