// Core line of a vortex, from a sample within it.
#pragma once

#include "palpa/mode/mode_context.h"

namespace palpa::detail {

/// Core line of a vortex: along `axis` through sample position + `offset_m`.
///
/// The axis n is the real eigenvector of the velocity's Jacobian J, where the other two eigenvalues are complex: the flow
/// rotates about it. The offset is a Newton step in the plane across n that never overshoots: where a round vortex' profile is
/// flatter along the step than across it, the derivative across is used instead, which gives the exact distance from the axis
/// of any round profile. So the step approaches the core from any point of a round or an elliptic vortex.
struct CoreLine {
  Vec3 axis;           ///< [1] unit length; either sign
  Vec3 offset_m;       ///< [m] across the axis
  double trust = 0.0;  ///< [1] 0…1: confidence in the step; 0: unknown
};

/// Zero across n of the velocity minus the velocity of the vortex itself (the reduced velocity): J δ = −(u − background) in the
/// plane across n.
/// \param velocity    smoothed, its Jacobian per hand metre
/// \param background  velocity of the vortex, in the field's unit, hand frame
CoreLine core_by_velocity(const VectorSample& velocity, const Vec3& background) noexcept;

/// Ridge of Q across n: H δ = −∇Q in that plane, with H the second derivative of Q. Independent of the observer.
/// \param q         Q of the smoothed velocity, its gradient per hand metre
/// \param hessian   of Q, per hand metre²
/// \param velocity  smoothed, for the axis
CoreLine core_by_q(const ScalarSample& q, const Mat3& hessian, const VectorSample& velocity) noexcept;

/// Strength at a position in a vortex: `strength_n`; unless `everywhere`, 0 where Q is less than 5 % of its maximum in the
/// data, and from there on at most k/2 times the depth within that level.
double in_vortex_n(const ModeContext& here, const FieldRef& q, bool everywhere, double strength_n) noexcept;

}  // namespace palpa::detail
