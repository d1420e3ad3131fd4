// Following a vector field.
#pragma once

#include "palpa/mode/mode.h"

namespace palpa {

/// Follow: a line primitive along the field, so that moving across it costs force and moving along it
/// is free. The sign of the field does not matter.
struct Follow {
  static constexpr auto type = "follow";
  static constexpr auto summary = "A rail along the field: free along it, held across it.";

  FieldRef field{};
  Strength strength_n{0.5};
  double drag_ns_per_m = 0.0;

  static constexpr auto parameters() {
    return std::tuple{
        vector_param("field", &Follow::field, "vector field to follow"),
        param("strength_n", &Follow::strength_n, "force that holds the hand on the line; above it the hand slides across"),
        param("drag_ns_per_m", &Follow::drag_ns_per_m, "viscous resistance to motion across the field", Range{0, 100})};
  }
  void place(const Here& here, PrimitiveSink out) const noexcept;
};

}  // namespace palpa
