// Law of the paper: the residual force, minimised with an adaptive step length.
#pragma once

#include "palpa/baseline/earlier_law.h"

namespace palpa::baseline {

/// "The new proxy position is then found by minimizing the residual force using an adaptive step-length numerical solver." The
/// paper (2005), after Eq. 8.
///
///     x ← x + h f_res(x),   f_res(x) = −k (x − probe) + the printed forces of all primitives (Eqs. 2–7)
///
/// From the paper: the residual force, its forces (zero on a point or line, and on a plane), the start at the last proxy, once
/// per frame. Our reading: every step is taken; h grows by a tenth while f_res keeps its direction and is halved where it turns
/// back; the first h is the reciprocal of the slope of spring and drags together; it ends after 200 steps or at a step below
/// 1e-12 m. Two other readings, a step that counts only if |f_res| or the energy falls, were measured to be worse
/// (docs/laws.md, and the test). A drag, absent from the paper, adds c/T times the residual.
///
/// Wrong in contact: on a primitive, f_res jumps and has no zero. The steps oscillate across the primitive and become short
/// before the motion along it is done. The printed forces are no balance there. The returned forces are others, found by sweeps
/// over the primitives: they make the proven bound small.
class Paper2005 final : public EarlierLaw {
 public:
  explicit Paper2005(std::size_t capacity = 64) : EarlierLaw(capacity) {}

 private:
  Moved move(const Posed& posed, std::span<Vec3> forces_n) noexcept override;
};

}  // namespace palpa::baseline
