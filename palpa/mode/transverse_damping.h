// Damping across a vector field.
#pragma once

#include "palpa/mode/mode.h"

namespace palpa {

/// Transverse damping: a line primitive along the field whose drag resists the part of the motion that goes
/// across the field, f = −c (v − (v·q) q); along it one is free. A strength resists at any speed, as `follow` does.
struct TransverseDamping {
  static constexpr auto type = "transverse_damping";
  static constexpr auto summary = "A flow thick as honey across, free along it.";

  FieldRef field{};
  double drag_ns_per_m = 5.0;
  Strength strength_n{0.0};

  static constexpr auto parameters() {
    using M = TransverseDamping;
    return std::tuple{
        vector_param("field", &M::field, "vector field along which motion is free"),
        param("drag_ns_per_m", &M::drag_ns_per_m, "force per speed of motion across the field", Range{0, 100}),
        param("strength_n", &M::strength_n, "force that motion across the field has to overcome, whatever its speed")};
  }
  /// At least one of drag and strength.
  std::string problem() const;
  void place(const Here& here, PrimitiveSink out) const noexcept;
};

}  // namespace palpa
