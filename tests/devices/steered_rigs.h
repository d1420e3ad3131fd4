// A SpaceMouse on a stand-in for spacenavd, a game controller that SDL makes up, and a window with a mouse.
#pragma once

#include <memory>

#include "tests/devices/rig.h"

namespace palpa {

std::unique_ptr<Rig> spacemouse_rig();
std::unique_ptr<Rig> pointer_rig();

/// What a controller's motors were last told: [0, 1], slow and fast.
struct Rumble {
  double slow = 0.0, fast = 0.0;
};
class ControllerRigBase : public Rig {
 public:
  virtual Rumble rumble() = 0;
};
std::unique_ptr<ControllerRigBase> controller_rig();

}  // namespace palpa
