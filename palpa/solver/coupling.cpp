#include "palpa/solver/coupling.h"

namespace palpa {

namespace {
bool in_range(double value, double above, double at_most) noexcept { return value > above && value <= at_most; }
}  // namespace

const char* problem_with(const CouplingOptions& options) noexcept {
  if (!in_range(options.stiffness_n_per_m, 0.0, 1e5)) return "stiffness_n_per_m must be above 0 and at most 100000";
  if (!(options.damping_ns_per_m >= 0.0 && options.damping_ns_per_m <= 100.0))
    return "damping_ns_per_m must be between 0 and 100";
  if (!in_range(options.max_force_n, 0.0, 100.0)) return "max_force_n must be above 0 and at most 100";
  if (!(options.impact_ns_per_m >= 0.0 && options.impact_ns_per_m <= 100.0)) return "impact_ns_per_m must be between 0 and 100";
  if (!in_range(options.max_torque_nm, 0.0, 10.0)) return "max_torque_nm must be above 0 and at most 10";
  const double turn_damping_nms_per_rad = options.turn_damping_nms_per_rad.value_or(0.0);
  if (!(turn_damping_nms_per_rad >= 0.0 && turn_damping_nms_per_rad <= 1.0))
    return "turn_damping_nms_per_rad must be between 0 and 1";
  return nullptr;
}

}  // namespace palpa
