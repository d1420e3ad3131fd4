#include "palpa/mode/modes.h"

namespace palpa {

std::string TransverseDamping::problem() const {
  const bool silent = strength_n.is_constant() && strength_n.constant_n == 0.0 && drag_ns_per_m == 0.0;
  return silent ? "drag_ns_per_m and strength_n are both 0; give one of them" : "";
}

void TransverseDamping::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const VectorSample sample = here.vector(field);
  if (!sample.inside || sample.value == Vec3{}) return;
  out.line(0, here.proxy_m, normalized(sample.value), here.newtons(strength_n), here.drag(drag_ns_per_m));
}

}  // namespace palpa
