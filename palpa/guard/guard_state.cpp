#include "palpa/guard/guard_state.h"

#include <cstddef>
#include <initializer_list>

namespace palpa {

namespace {
const char* name_in(std::initializer_list<const char*> names, std::size_t i) noexcept {
  return i < names.size() ? names.begin()[i] : "?";
}
}  // namespace

const char* name_of(GuardState state) noexcept {
  return name_in({"pass", "limited", "fault", "waiting", "ramp", "damped", "falling", "off"}, static_cast<std::size_t>(state));
}
const char* name_of(GuardCause cause) noexcept {
  return name_in({"none", "start", "not_finite", "no_position", "device_fault", "link_lost", "late", "speed", "view_moves",
                  "dead_man", "panic", "stops", "other_hand", "link_stale", "link_closed"},
                 static_cast<std::size_t>(cause));
}
const char* format_cause(GuardCause cause) noexcept {
  return name_in({"", "the session begins: keep the hand where nothing is felt", "the force is not finite",
                  "the device does not know where the hand is", "the device says that something is wrong",
                  "the device did not take the force", "ticks were missed", "the hand is too fast",
                  "the view, the map or the clutch moves", "the button that has to be held is not", "a person said stop",
                  "the program is being stopped", "the other hand has a fault", "the far data do not answer",
                  "there is no connection to the far data"},
                 static_cast<std::size_t>(cause));
}

// A limit that is no number stays none: the guard allows no force then.
GuardOptions guard_options_for(const DeviceLimits& limits, double scene_max_force_n) noexcept {
  return {.max_force_n = scene_max_force_n < limits.max_force_n ? scene_max_force_n : limits.max_force_n,
          .continuous_force_n = limits.continuous_force_n,
          .max_damping_ns_per_m = limits.max_damping_ns_per_m,
          .device_damping_ns_per_m = limits.damping_ns_per_m,
          .max_torque_nm = limits.max_torque_nm,
          .max_turn_damping_nms_per_rad = limits.max_turn_damping_nms_per_rad};
}

}  // namespace palpa
