// Primitives that one mode places at one point of one field.
#pragma once

#include <utility>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/mode/mode_context.h"
#include "palpa/solver/primitives.h"

namespace palpa::test {

class Place {
 public:
  /// \param at  [m] proxy and probe, hand frame
  Place(FieldPtr field, const Vec3& at, const Similarity& map = {}) : fields_{std::move(field)}, samples_(fields_, map) {
    here_.proxy_m = here_.probe_m = here_.at_m = at;
    here_.time_step_s = 1e-3;
    here_.stiffness_n_per_m = stiffness_n_per_m;
    here_.finest_m = 1e-3;
    out_.clear(at);
  }
  static constexpr double stiffness_n_per_m = 800.0;
  template <class M, class... Memory>
  const PrimitiveSet& of(const M& mode, const Memory&... memory) {
    mode.place(here_, memory..., out_);
    return out_;
  }
  const ModeContext& here() const { return here_; }

 private:
  std::vector<FieldPtr> fields_;
  Samples samples_;
  ModeContext here_{samples_, {}, {}, {}};
  PrimitiveSet out_;
};

}  // namespace palpa::test
