// Magnitudes and components: scalar fields that are another field's vector sample, looked at otherwise.
#pragma once

#include <optional>

#include "palpa/data/field.h"

namespace palpa::detail {

/// What is taken of a vector.
struct Pointwise {
  static constexpr int magnitude = -1;
  FieldPtr of;           ///< the vector field
  int axis = magnitude;  ///< of the component, 0 to 2
};

/// What a magnitude or a component is taken of; none for other fields, and for those that change with time.
std::optional<Pointwise> pointwise_of(const Field& field) noexcept;

/// |u|, with gradient Jᵀu/|u|, which is 0 where u is, the kink of |u|; or a component.
ScalarSample taken_of(const VectorSample& u, int axis) noexcept;

}  // namespace palpa::detail
