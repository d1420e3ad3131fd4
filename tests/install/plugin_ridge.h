// The mode of the tested plug-ins; a kind adds its type, and code at construction.
#pragma once

#include "palpa/palpa.h"

namespace palpa_test {

template <class Kind>
struct RidgeOf {
  static constexpr auto type = Kind::type;
  palpa::FieldRef field;
  palpa::Strength strength_n{1.0};
  RidgeOf() {
    if constexpr (requires { Kind::begin(); }) Kind::begin();
  }
  static constexpr auto parameters() {
    return std::tuple{palpa::param("field", &RidgeOf::field, "scalar field to feel"),
                      palpa::param("strength_n", &RidgeOf::strength_n, "force that holds the hand", palpa::Range{0, 10})};
  }
  void place(const palpa::ModeContext& here, palpa::PrimitiveSink out) const noexcept {
    const auto sample = here.scalar(field);
    if (!sample.inside || norm(sample.gradient) == 0) return;
    out.plane(0, here.proxy_m, normalized(sample.gradient), here.newtons(strength_n));
  }
};

}  // namespace palpa_test
