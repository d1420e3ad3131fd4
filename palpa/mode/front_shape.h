// The front of a vector field.
#pragma once

#include "palpa/mode/mode.h"

namespace palpa {

/// Front shape: a plane across the field at the proxy, its normal along the field. One moves with the field and
/// along its front freely, and against it only with force.
struct FrontShape {
  static constexpr auto type = "front_shape";
  static constexpr auto summary = "A wall across the field: one moves with it, not against it.";

  FieldRef field{};
  Strength strength_n{0.5};
  double drag_ns_per_m = 0.0;

  static constexpr auto parameters() {
    return std::tuple{
        vector_param("field", &FrontShape::field, "vector field whose front is felt"),
        param("strength_n", &FrontShape::strength_n, "force at which the hand gets through against the field"),
        param("drag_ns_per_m", &FrontShape::drag_ns_per_m, "viscous resistance to motion against the field", Range{0, 100})};
  }
  void place(const Here& here, PrimitiveSink out) const noexcept;
};

}  // namespace palpa
