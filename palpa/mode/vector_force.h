// A push along a vector field.
#pragma once

#include "palpa/mode/mode.h"

namespace palpa {

/// Vector force: a directed force along the field, the simplest mode of vector data: one is carried by
/// the flow. Where the direction turns within less than 2s/k it is weaker, s ≤ (k/2)·|V|/‖J‖, so that it
/// fades at stagnation points and in cores.
struct VectorForce {
  static constexpr auto type = "vector_force";
  static constexpr auto summary = "A push along the field: one is carried by the flow.";

  FieldRef field{};
  Strength strength_n{0.5};

  static constexpr auto parameters() {
    return std::tuple{vector_param("field", &VectorForce::field, "vector field that pushes"),
                      param("strength_n", &VectorForce::strength_n,
                            "force of the push; a function of magnitude(FIELD) makes fast places push more")};
  }
  void place(const Here& here, PrimitiveSink out) const noexcept;
};

}  // namespace palpa
