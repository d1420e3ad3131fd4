// Limits of a device, for C and of C.
#pragma once

#include "palpa/c.h"
#include "palpa/device/device.h"

namespace palpa::c {

/// Limits that a program gives, of a known size. Throws WrongArgument.
DeviceLimits limits_of(const palpa_limits& given);
/// For a program; without a token and without buttons. Allocates nothing; any thread.
palpa_limits limits_of(const DeviceLimits& limits) noexcept;

}  // namespace palpa::c
