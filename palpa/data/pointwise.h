// Magnitudes and components: scalar fields of another field's vector sample.
#pragma once

#include <optional>

#include "palpa/data/field.h"

namespace palpa::detail {

/// Source of a magnitude or component.
struct Pointwise {
  static constexpr int magnitude = -1;
  FieldPtr of;           ///< vector field
  int axis = magnitude;  ///< of the component, 0 to 2
};

/// Source of a magnitude or component, also of one that changes with time; none for other fields.
std::optional<Pointwise> pointwise_of(const Field& field) noexcept;

/// |u|, with gradient Jᵀu/|u|, 0 at the kink u = 0; or a component.
ScalarSample taken_of(const VectorSample& u, int axis) noexcept;

}  // namespace palpa::detail
