// A pull along the gradient of a scalar field.
#pragma once

#include <limits>

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
  double noise_per_m = 0.0;  ///< [unit of the field per world metre]

  static constexpr auto parameters() {
    using M = GradientForce;
    return std::tuple{derived_param("field", &M::field, Derivation::smooth, "scalar field whose slope is felt"),
                      param("strength_n", &M::strength_n,
                            "force of the pull; a function of gradient_magnitude(FIELD) makes steep places pull more"),
                      choice_param("towards", &M::towards, "which way it pulls: towards high or low values", "high", "low"),
                      param("noise_per_m", &M::noise_per_m,
                            "steepness of noise, in the field's unit per metre of the world: no pull where the slope is not "
                            "above it, all of it from three times that on",
                            Range{0, std::numeric_limits<double>::infinity()})};
  }
  void place(const Here& here, PrimitiveSink out) const noexcept;
};

}  // namespace palpa
