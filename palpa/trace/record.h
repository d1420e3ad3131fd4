// One whole tick as it is recorded.
#pragma once

#include <cstdint>

#include "palpa/tick/session.h"

namespace palpa {

/// What the guard did with a tick's force.
enum class GuardState : std::uint8_t {
  pass,     ///< let it through
  limited,  ///< shortened it to the limit
  fault,    ///< it was not finite: nothing went out
};

/// What these are called in files.
const char* name_of(GuardState state) noexcept;
const char* name_of(TickStatus status) noexcept;
const char* name_of(Stop stop) noexcept;
const char* name_of(SessionEventKind kind) noexcept;

/// What the loop knows of a tick: the session's answer and what became of it.
struct TickFrame {
  std::int64_t tick = 0;  ///< counts from 0
  double t_s = 0.0;       ///< since the session began
  double dt_s = 0.0;      ///< the time step that the session was given
  Tick result;
  Vec3 command_n;  ///< what was sent to the device: after the guard
  GuardState guard = GuardState::pass;
  double snap_n = 0.0;  ///< the step of the force as the proxy let go of something other than a level, if that is spread out
  std::uint32_t buttons = 0;
  double late_us = 0.0;    ///< how late the tick began; 0 on a simulated clock
  double tick_us = 0.0;    ///< time inside `Session::tick`; 0 where it was not measured
  double device_us = 0.0;  ///< time inside the device's read and write; 0 where it was not measured
};

}  // namespace palpa
