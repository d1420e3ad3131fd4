// An Inverse3 on a stand-in for the Inverse Service.
#pragma once

#include <memory>
#include <string>

#include "palpa/device/backend.h"
#include "tests/devices/inverse3_stand_in.h"
#include "tests/devices/rig.h"

namespace palpa {

std::unique_ptr<Rig> inverse3_rig();

namespace test {

/// What palpa-device-inverse3.so of this build exports. Throws std::runtime_error where it cannot be loaded.
const DeviceBackend& inverse3_backend();

/// The stand-in's axes, from the vendor's words "x to the right, y forward, z up", seen by a hand whose z points to the user.
Vec3 service_from_hand(const Vec3& hand);
Vec3 hand_from_service(const Vec3& service);

}  // namespace test
}  // namespace palpa
