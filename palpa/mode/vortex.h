// Vortices of a velocity field, felt in two ways.
#pragma once

#include "palpa/mode/mode.h"

namespace palpa {

/// Both vortex modes feel Q = (|W|² − |S|²)/2 of the smoothed velocity, which is positive where the flow
/// turns more than it deforms, and does not depend on who moves along with it. ∇Q points to the core of a
/// smooth vortex, exactly where it is round. A strength that is a number is felt where Q is at least 5 % of
/// its maximum in the data, from there on not more than k/2 × the depth; a strength that is a function says
/// itself where, best as a function of q(FIELD). At the core, where the direction turns, it fades over 2s/k.

/// Vortex force (paper: vortex core, directed force): a pull towards the core.
struct VortexForce {
  static constexpr auto type = "vortex_force";
  static constexpr auto summary = "A pull towards the core of a vortex.";

  FieldRef field{};
  Strength strength_n{0.5};

  static constexpr auto parameters() {
    using M = VortexForce;
    return std::tuple{derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
                      param("strength_n", &M::strength_n,
                            "force of the pull; a number: where Q is at least 5 % of its maximum; or a function of q(FIELD)")};
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

  static constexpr auto parameters() {
    using M = VortexPlane;
    return std::tuple{derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
                      param("strength_n", &M::strength_n,
                            "force that holds the hand in the vortex; a number: where Q is at least 5 % of its maximum; or a "
                            "function of q(FIELD)")};
  }
  struct Memory {
    bool captured = false;
    double value = 0.0;  ///< Q of the level that the plane stands on, [1/s²] where velocities are in m/s
  };
  void place(const Here& here, const Memory& memory, PrimitiveSet& out) const noexcept;
  void settle(const Settled& settled, Memory& memory) const noexcept;
};

}  // namespace palpa
