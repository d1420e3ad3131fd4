// Laws of the constraint-based systems: each constraint moves the proxy along its own axes.
#pragma once

#include "palpa/baseline/earlier_law.h"

namespace palpa::baseline {

/// The proxy is moved "along the axes of a local reference frame": Ikits, Brederson, Hansen, Johnson, A Constraint-Based
/// Technique for Haptic Volume Exploration (2003). The update below is our reading; it also serves Lundin et al. (2002), whose
/// surface, friction and viscosity are thresholds of this kind.
///
/// With D the vector from the proxy to the probe and e an axis of the frame, the proxy moves along e by
///     m = 0 where k|D·e| ≤ t,   else D·e shortened by t/k        (t: the axis's threshold [N])
/// and the moves of all axes are added. In primitives, by our reading: t is the strength; a plane is an axis with a threshold
/// for one sign; a line is the two axes across it with a common threshold (friction circle); the space not spanned by planes
/// and lines follows the probe; a point is a threshold on the whole motion, applied last; a directed force moves the target by
/// force/k; a drag shortens the move above the threshold by 1/(1 + c/(kT)); a primitive beside the proxy counts from its own
/// position.
///
/// On mutually orthogonal primitives at the proxy (and points there too) this is the exact balance. Wrong for other sets: with
/// two axes at an angle θ and zero thresholds the proxy misses the probe by |cos θ| of the distance (paper, Fig. 5 b), and
/// moves too far along their common direction. Three axes less than 60° apart overshoot by more than the distance itself: the
/// error grows from tick to tick.
///
/// The sequential variant moves along each constraint's axes from the end of the previous move: the last constraint is exact
/// along its axes, the earlier ones are not, and the result depends on the order of the primitives.
class Ikits2003 final : public EarlierLaw {
 public:
  enum class Moves { added, one_after_another };
  explicit Ikits2003(Moves moves = Moves::added, std::size_t capacity = 64) : EarlierLaw(capacity), moves_(moves) {}

 private:
  Moved move(const Posed& posed, std::span<Vec3> forces_n) noexcept override;

  Moves moves_;
};

}  // namespace palpa::baseline
