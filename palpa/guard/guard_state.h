// States, causes, inputs and limits of the guard.
#pragma once

#include <cstdint>
#include <limits>

#include "palpa/device/device.h"

namespace palpa {

/// Effect of the guard on a tick's force (docs/safety.md).
enum class GuardState : std::uint8_t {
  pass,     ///< unchanged
  limited,  ///< shortened to the limit, or limited in growth or rotation
  fault,    ///< not finite: zero
  waiting,  ///< zero until the force would be small
  ramp,     ///< a growing share
  damped,   ///< unchanged plus damping, by energy output beyond input
  falling,  ///< the last command decreases to zero
  off,      ///< zero until a person resumes
};

/// Cause of a reduced or zero force.
enum class GuardCause : std::uint8_t {
  none,
  start,         ///< session start, or resumed by a person
  not_finite,    ///< the force is not finite
  no_position,   ///< the device has no position, or an invalid one
  device_fault,  ///< the device reports a fault
  link_lost,     ///< the device did not accept the last force
  late,          ///< three ticks or more were missed while motors held the last force
  speed,         ///< the hand is too fast
  view_moves,    ///< the view, the map from hand to data, or the clutch moves
  dead_man,      ///< the dead-man button is released
  panic,         ///< stopped by a person
  stops,         ///< the program stops or ends
  other_hand,    ///< another hand of the loop has a fault, or was stopped by a person
  link_stale,    ///< the model of far data is older than usual by 100 ms
  link_closed,   ///< no connection to far data, or a model of an unknown scene
};

/// Inputs of a tick from the loop besides the probe; each a bit of `TickFrame::circumstances`.
enum class Circumstance : std::uint8_t {
  device_fault,
  link_lost,
  late,
  view_moves,
  panic,
  resume,
  new_scene,
  stops,
  other_hand,
  link_stale,
  link_closed
};
constexpr std::uint32_t bit_of(Circumstance circumstance) noexcept { return 1u << static_cast<unsigned>(circumstance); }

/// Names in files; string literals.
const char* name_of(GuardState state) noexcept;
const char* name_of(GuardCause cause) noexcept;
/// Formats the cause as half a sentence.
const char* format_cause(GuardCause cause) noexcept;

/// Limits of the guard (docs/safety.md).
struct GuardOptions {
  double max_force_n = 3.3;  ///< of a command
  bool motors = true;        ///< a person holds a device; false: a simulated hand, with the limit alone
  double continuous_force_n = std::numeric_limits<double>::infinity();    ///< continuous force of the motors
  double thermal_s = 20.0;                                                ///< > 0: time constant of their warmth
  double slew_n_per_s = 1000.0;                                           ///< > 0: largest growth or turn rate of a command
  double max_speed_m_per_s = 2.0;                                         ///< > 0: of the hand
  double ramp_s = 0.7;                                                    ///< > 0: from zero to full force
  double max_damping_ns_per_m = std::numeric_limits<double>::infinity();  ///< of the device
  double device_damping_ns_per_m = 0.0;                                   ///< of the device's own mechanics
  std::uint32_t dead_man_buttons = 0;                                     ///< one of these must be held; 0: none
  double max_torque_nm = 0.0;                                             ///< of a command; 0: no torque is sent
  double max_turn_damping_nms_per_rad = std::numeric_limits<double>::infinity();  ///< of the device
};
/// Options for a device and a scene's limit [N]; the torque's limit is the device's.
GuardOptions guard_options_for(const DeviceLimits& limits, double scene_max_force_n) noexcept;

}  // namespace palpa
