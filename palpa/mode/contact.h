// Contact of the proxy with a placed primitive.
#pragma once

#include "palpa/solver/primitives.h"

namespace palpa {

/// Contact with a primitive of the last accepted sub-step.
struct Contact {
  /// Of the level: free → held → yielding → free. A level that yields stays so until it is free.
  enum class Phase : std::uint8_t { free, held, yielding };

  PrimitiveId id;
  PrimitiveState state = PrimitiveState::off;
  Phase phase = Phase::free;
  bool yields = false;  ///< strength reduced (data end nearby, or its level jumped): a slip is no break-through
  HeldLevel level;      ///< level of its placement; none if it stands on no level
  /// [hand m] From the proxy to its *foot*, the point of an elastic level from which the proxy has pressed it in
  /// (docs/theory.md 8.11); zero if it has not.
  Vec3 offset_m;
  double held_j = 0.0;  ///< energy stored in the level
};

}  // namespace palpa
