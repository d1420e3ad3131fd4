// One whole tick as it is recorded.
#pragma once

#include <cstdint>
#include <vector>

#include "palpa/tick/session.h"

namespace palpa {

enum class GuardState : std::uint8_t { pass, limited, fault };
const char* name_of(GuardState state) noexcept;

/// What the loop knows of a tick besides the session.
struct TickFrame {
  std::int64_t tick = 0;
  double t_s = 0.0;
  double dt_s = 0.0;
  Tick result;
  Vec3 command_n;                       ///< after the guard
  GuardState guard = GuardState::pass;
  std::uint32_t buttons = 0;
  double late_us = 0.0;
  double tick_us = 0.0;
  double device_us = 0.0;
};

}  // namespace palpa
