// Vortices of a velocity field, felt as a pull and as a tube.
#pragma once

#include <string>

#include "palpa/mode/mode.h"

namespace palpa {

/// All vortex modes find vortices by Q = (|W|² − |S|²)/2 of the smoothed velocity, which is positive where the flow
/// turns more than it deforms, and does not depend on who moves along with it. A strength that is a number is
/// felt where Q is at least 5 % of its maximum in the data, from there on not more than k/2 × the depth; a
/// strength that is a function says itself where, best as a function of q(FIELD).
///
/// What points to the core is chosen:
///   q                 ∇Q: exact in a smooth vortex where it is round, and the same for any observer. Nothing in a core
///                     that turns like a solid, where Q is constant.
///   vorticity         ω × (u − b), of the literature: right where the vortex stands still for the observer who
///                     moves at b, the `background`, and ω keeps its sign.
///   reduced_velocity  the Newton step to where u − b has no part across the axis of the turning: right, and the distance
///                     with it, in any core, also a solid one, for that observer alone.
enum class VortexDirection { q, vorticity, reduced_velocity };

/// Vortex force (paper: vortex core, directed force): a pull towards the core, fading where its direction turns.
struct VortexForce {
  static constexpr auto type = "vortex_force";
  static constexpr auto summary = "A pull towards the core of a vortex.";

  FieldRef field{};     ///< Q of the velocity
  FieldRef velocity{};  ///< the velocity, smoothed
  Strength strength_n{0.5};
  VortexDirection direction = VortexDirection::q;
  Vec3 background{};  ///< [unit of the field] along the axes of the world

  static constexpr auto parameters() {
    using M = VortexForce;
    return std::tuple{derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
                      companion_param(&M::velocity, &M::field, Derivation::smooth_vector, &M::needs_velocity),
                      param("strength_n", &M::strength_n,
                            "force of the pull; a number: where Q is at least 5 % of its maximum; or a function of q(FIELD)"),
                      choice_param("direction", &M::direction, "what points to the core", "q", "vorticity", "reduced_velocity"),
                      param("background", &M::background, background_sentence)};
  }
  bool needs_velocity() const { return direction != VortexDirection::q; }
  /// A background only where the direction depends on it.
  std::string problem() const;
  void place(const Here& here, PrimitiveSink out) const noexcept;

  /// How that parameter reads, for all vortex modes.
  static constexpr std::string_view background_sentence =
      "velocity at which the vortex moves along, in the field's unit along the world's axes; not with direction = \"q\"";
};

/// Vortex plane (paper: vortex shape, plane): a tube that one enters freely and leaves against force. The plane's
/// normal points to the core. By q it stands on the level of Q that the proxy has reached; the other directions know no
/// level, so there it stands at the proxy.
struct VortexPlane {
  static constexpr auto type = "vortex_plane";
  static constexpr auto summary = "A tube around the core of a vortex: free to enter, held inside.";

  FieldRef field{};     ///< Q of the velocity
  FieldRef velocity{};  ///< the velocity, smoothed
  Strength strength_n{0.5};
  VortexDirection direction = VortexDirection::q;
  Vec3 background{};  ///< [unit of the field] along the axes of the world

  static constexpr auto parameters() {
    using M = VortexPlane;
    return std::tuple{derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
                      companion_param(&M::velocity, &M::field, Derivation::smooth_vector, &M::needs_velocity),
                      param("strength_n", &M::strength_n,
                            "force that holds the hand in the vortex; a number: where Q is at least 5 % of its maximum; or a "
                            "function of q(FIELD)"),
                      choice_param("direction", &M::direction, "what points to the core", "q", "vorticity", "reduced_velocity"),
                      param("background", &M::background, VortexForce::background_sentence)};
  }
  bool needs_velocity() const { return direction != VortexDirection::q; }
  /// A background only where the direction depends on it.
  std::string problem() const;

  struct Memory {
    bool captured = false;
    double value = 0.0;  ///< Q of the level that the plane stands on, [1/s²] where velocities are in m/s
  };
  void place(const Here& here, const Memory& memory, PrimitiveSink out) const noexcept;
  void settle(const Settled& settled, Memory& memory) const noexcept;
};

}  // namespace palpa
