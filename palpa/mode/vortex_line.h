// The core line of a vortex.
#pragma once

#include <string>

#include "palpa/mode/vortex.h"

namespace palpa {

/// Vortex line: a line primitive on the core line of the vortex around the proxy, one Newton step from it. Within reach
/// of its strength the hand is held on the core and free along it; further away it is drawn there.
///
/// Unlike the other primitives that resist, it does not pass through the proxy, so it brings energy in, like a
/// directed force. It buzzes less: the place of the line hardly depends on where it is looked for, so it may keep its
/// whole strength at the core, where a directed force has to fade.
struct VortexLine {
  static constexpr auto type = "vortex_line";
  static constexpr auto summary = "A pull onto the core line of a vortex, which holds the hand there, free along it.";

  /// How the core is found: by the ridge of Q, or where the reduced velocity has no part across the axis.
  enum class By { q, reduced_velocity };

  FieldRef field{};     ///< Q of the velocity
  FieldRef velocity{};  ///< the velocity, smoothed
  Strength strength_n{0.5};
  By direction = By::q;
  Vec3 background{};  ///< [unit of the field] along the axes of the world

  static constexpr auto parameters() {
    using M = VortexLine;
    return std::tuple{
        derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
        companion_param(&M::velocity, &M::field, Derivation::smooth_vector, &M::needs_velocity),
        param("strength_n", &M::strength_n,
              "force onto the core; a number: where Q is at least 5 % of its maximum; or a function of q(FIELD)"),
        choice_param("direction", &M::direction, "what the step to the core is taken from", "q", "reduced_velocity"),
        param("background", &M::background, VortexForce::background_sentence)};
  }
  bool needs_velocity() const { return true; }  // for the axis
  /// A background only where the step depends on it.
  std::string problem() const;
  void place(const Here& here, PrimitiveSink out) const noexcept;
};

}  // namespace palpa
