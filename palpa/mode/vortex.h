// Vortices of a velocity field, felt in two ways.
#pragma once

#include "palpa/mode/mode.h"

namespace palpa {

/// Both vortex modes feel Q = (|W|² − |S|²)/2 of the smoothed velocity, which is positive where the flow
/// turns more than it deforms, and does not depend on who moves along with it. ∇Q points to the core of a
/// smooth vortex. A vortex is felt where Q is at least `threshold_share` of its maximum in the data; from
/// there on strengths fade in so that they never exceed k/2 × the depth in it, and they fade out over 2s/k
/// at the core, where the direction turns.

/// Vortex force (paper: vortex core, directed force): a pull towards the core.
struct VortexForce {
  static constexpr auto type = "vortex_force";
  static constexpr auto summary = "A pull towards the core of a vortex.";

  FieldRef field{};
  Strength strength_n{0.5};
  double threshold_share = 0.05;  ///< [1] of the largest Q

  static constexpr auto parameters() {
    using M = VortexForce;
    return std::tuple{derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
                      param("strength_n", &M::strength_n, "force of the pull"),
                      param("threshold_share", &M::threshold_share, "a vortex is where Q is at least this share of its maximum",
                            Range{0, 1})};
  }
  void place(const Here& here, PrimitiveSet& out) const noexcept;
};

/// Vortex plane (paper: vortex shape, plane): a tube that one enters freely and leaves against force. The
/// plane stands on the level of Q that the proxy has reached, its normal towards the core.
struct VortexPlane {
  static constexpr auto type = "vortex_plane";
  static constexpr auto summary = "A tube around the core of a vortex: free to enter, held inside.";

  FieldRef field{};
  Strength strength_n{0.5};
  double threshold_share = 0.05;  ///< [1] of the largest Q

  static constexpr auto parameters() {
    using M = VortexPlane;
    return std::tuple{derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
                      param("strength_n", &M::strength_n, "force that holds the hand in the vortex"),
                      param("threshold_share", &M::threshold_share, "a vortex is where Q is at least this share of its maximum",
                            Range{0, 1})};
  }
  struct Memory {
    bool captured = false;
    double value = 0.0;  ///< Q of the level that the plane stands on, [1/s²] where velocities are in m/s
  };
  void place(const Here& here, const Memory& memory, PrimitiveSet& out) const noexcept;
  void settle(const Settled& settled, Memory& memory) const noexcept;
};

}  // namespace palpa
