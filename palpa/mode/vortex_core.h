// Where the core of a vortex lies, seen from a place within it: what the vortex modes share.
#pragma once

#include "palpa/mode/mode_context.h"

namespace palpa::detail {

/// The core line of a vortex, seen from the sampled place: a line along `axis` through place + `offset_m`.
///
/// The axis n is the real eigenvector of the velocity's Jacobian J, where the other two eigenvalues are complex: the flow
/// turns about it. The offset is a Newton step in the plane across n that never goes too far: where a round vortex'
/// profile is flatter along the step than across it, the derivative across stands in, as it gives the distance from
/// the axis of any round profile exactly. So the step brings any place of a round or an elliptic vortex nearer.
struct CoreLine {
  Vec3 axis;           ///< [1] unit length; either sign
  Vec3 offset_m;       ///< [m] across the axis
  double trust = 0.0;  ///< [1] 0…1: how far the step can be believed; 0: nothing is known
};

/// The zero of the velocity across n, less the velocity of the vortex itself (the reduced velocity):
/// J δ = −(u − background) in the plane across n.
/// \param velocity    smoothed, its Jacobian per hand metre
/// \param background  velocity at which the vortex moves along, in the field's unit, hand frame
CoreLine core_by_velocity(const VectorSample& velocity, const Vec3& background) noexcept;

/// The ridge of Q across n: H δ = −∇Q in that plane, with H the second derivative of Q. The same for any observer.
/// \param q         Q of the smoothed velocity, its gradient per hand metre
/// \param hessian   of Q, per hand metre²
/// \param velocity  smoothed, for the axis
CoreLine core_by_q(const ScalarSample& q, const Mat3& hessian, const VectorSample& velocity) noexcept;

/// The strength at a place of a vortex: `strength_n`, and, unless it is felt `everywhere`, 0 where Q is less than
/// 5 % of its maximum in the data, and from there on not more than k/2 times the depth within that level.
double in_vortex_n(const ModeContext& here, const FieldRef& q, bool everywhere, double strength_n) noexcept;

}  // namespace palpa::detail
