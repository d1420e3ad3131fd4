#include "palpa/c/device_limits.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "palpa/c/failure.h"

namespace palpa::c {

DeviceLimits limits_of(const palpa_limits& given) {
  const auto check = [](double value, bool may_be_infinite, const char* name) {
    if (!(value >= 0.0) || (!may_be_infinite && std::isinf(value)))
      throw WrongArgument(std::string(name) + " cannot be; give a number of at least 0" +
                          (may_be_infinite ? ", or infinity for no limit" : ""));
  };
  check(given.max_force_n, false, "max_force_n");
  check(given.max_stiffness_n_per_m, true, "max_stiffness_n_per_m");
  check(given.max_damping_ns_per_m, true, "max_damping_ns_per_m");
  check(given.continuous_force_n, true, "continuous_force_n");
  check(given.encoder_step_m, false, "encoder_step_m");
  check(given.damping_ns_per_m, false, "damping_ns_per_m");
  constexpr double largest = 1e9;  // that a message can hold
  return {.max_force_n = std::min(given.max_force_n, largest),
          .has_motors = given.has_motors != 0,
          .max_stiffness_n_per_m = std::min(given.max_stiffness_n_per_m, largest),
          .encoder_step_m = std::min(given.encoder_step_m, largest),
          .continuous_force_n = given.continuous_force_n,
          .max_damping_ns_per_m = given.max_damping_ns_per_m,
          .damping_ns_per_m = given.damping_ns_per_m};
}

palpa_limits limits_of(const DeviceLimits& limits) noexcept {
  palpa_limits out{};
  out.has_motors = limits.has_motors;
  out.max_force_n = limits.max_force_n;
  out.max_stiffness_n_per_m = limits.max_stiffness_n_per_m;
  out.max_damping_ns_per_m = limits.max_damping_ns_per_m;
  out.continuous_force_n = limits.continuous_force_n;
  out.encoder_step_m = limits.encoder_step_m;
  out.damping_ns_per_m = limits.damping_ns_per_m;
  return out;
}

}  // namespace palpa::c
