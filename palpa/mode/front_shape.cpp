#include "palpa/mode/modes.h"

namespace palpa {

void FrontShape::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  const VectorSample sample = here.vector(field);
  if (!sample.inside || sample.value == Vec3{}) return;
  out.plane(0, here.proxy_m, normalized(sample.value), here.newtons(strength_n), {}, here.drag(drag_ns_per_m));
}

}  // namespace palpa
