#include "palpa/mode/modes.h"
#include "palpa/mode/placement.h"

namespace palpa {

void GradientForce::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const ScalarSample sample = here.scalar(field);
  const double steepness = norm(sample.gradient);
  if (!sample.inside || !(steepness > 0.0)) return;
  const double steady_n = detail::steady_strength_n(here.stiffness_n_per_m, steepness, here.hessian(field));
  const Vec3 uphill = normalized(sample.gradient);
  const double weight = detail::gradient_weight(here, sample.gradient, noise_per_m);
  out.directed(0, towards == Towards::high ? uphill : -uphill, weight * std::min(here.newtons(strength_n), steady_n));
}

}  // namespace palpa
