// A pull along the gradient of a scalar field.
#pragma once

#include "palpa/mode/mode.h"

namespace palpa {

/// Gradient force (paper: directed force): a pull uphill or downhill in a scalar field, smoothed when it
/// is loaded. A pull whose direction turns within less than 2s/k would buzz at the top of a hill, so there
/// it is weaker: s ≤ (k/2)·|g|/‖∂g/∂x‖ with g the gradient.
struct GradientForce {
  static constexpr auto type = "gradient_force";
  static constexpr auto summary = "A pull uphill or downhill in a scalar field.";

  enum class Towards { high, low };

  FieldRef field{};
  Strength strength_n{0.5};
  Towards towards = Towards::high;

  static constexpr auto parameters() {
    using M = GradientForce;
    return std::tuple{derived_param("field", &M::field, Derivation::smooth, "scalar field whose slope is felt"),
                      param("strength_n", &M::strength_n,
                            "force of the pull; a function of gradient_magnitude(FIELD) makes steep places pull more"),
                      choice_param("towards", &M::towards, "which way it pulls: towards high or low values", "high", "low")};
  }
  void place(const Here& here, PrimitiveSet& out) const noexcept;
};

}  // namespace palpa
