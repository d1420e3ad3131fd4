#include "palpa/mode/modes.h"

namespace palpa {

std::string Viscosity::problem() const {
  const bool silent = strength_n.is_constant() && strength_n.constant_n == 0.0 && drag_ns_per_m == 0.0;
  return silent ? "neither strength_n nor drag_ns_per_m is given; give one of them" : "";
}

void Viscosity::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  out.point(0, here.proxy_m, here.newtons(strength_n), here.drag(drag_ns_per_m));
}

}  // namespace palpa
