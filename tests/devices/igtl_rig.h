// A tracker on a stand-in for a server of OpenIGTLink.
#pragma once

#include <memory>

#include "tests/devices/rig.h"

namespace palpa {

std::unique_ptr<Rig> igtl_rig();

namespace test {

/// RAS of a vector of the hand frame, in its unit.
Vec3 ras_from_hand(const Vec3& hand);

}  // namespace test
}  // namespace palpa
