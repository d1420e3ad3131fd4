// Force Dimension's and 3D Systems' devices on stand-ins for their libraries.
#pragma once

#include <memory>

#include "palpa/device/backend.h"
#include "tests/devices/rig.h"

namespace palpa {

/// What palpa-device-NAME.so of this build exports. Throws std::runtime_error where it cannot be loaded.
const DeviceBackend& built_backend(const std::string& name);

std::unique_ptr<Rig> force_dimension_rig();
std::unique_ptr<Rig> openhaptics_rig();

}  // namespace palpa
