// Resistance to all motion.
#pragma once

#include "palpa/mode/mode.h"

namespace palpa {

/// Viscosity: a point primitive at the proxy. Its strength resists motion with the same force at any
/// speed (Coulomb; the paper's mode); its drag resists in proportion to the speed (true viscosity, f = c v).
struct Viscosity {
  static constexpr auto type = "viscosity";
  static constexpr auto summary = "Resistance to motion in every direction, where the data say so.";

  FieldRef field{};
  Strength strength_n{0.0};
  double drag_ns_per_m = 0.0;

  static constexpr auto parameters() {
    return std::tuple{
        optional_field_param("field", &Viscosity::field, "field in whose data the resistance is felt; left out: everywhere"),
        param("strength_n", &Viscosity::strength_n, "force that motion has to overcome, whatever its speed"),
        param("drag_ns_per_m", &Viscosity::drag_ns_per_m, "force per speed: true viscosity", Range{0, 100})};
  }
  /// At least one of strength and drag.
  std::string problem() const;
  void place(const Here& here, PrimitiveSink out) const noexcept;
};

}  // namespace palpa
