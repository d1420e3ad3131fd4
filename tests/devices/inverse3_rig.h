// An Inverse3 on a stand-in for the Inverse Service.
#pragma once

#include <memory>
#include <string>

#include "tests/devices/inverse3_stand_in.h"
#include "tests/devices/rig.h"

namespace palpa {

std::unique_ptr<Rig> inverse3_rig();

namespace test {

/// The stand-in's axes, from the vendor's words "x to the right, y forward, z up", for a hand whose z points to the user.
Vec3 service_from_hand(const Vec3& hand);
Vec3 hand_from_service(const Vec3& service);

}  // namespace test
}  // namespace palpa
