// SpaceMouse on a stand-in for spacenavd, virtual game controller of SDL, window with a mouse.
#pragma once

#include <memory>

#include "tests/devices/rig.h"

namespace palpa {

std::unique_ptr<Rig> spacemouse_rig();
std::unique_ptr<Rig> pointer_rig();

/// The last command to a controller's motors: [0, 1], slow and fast.
struct Rumble {
  double slow = 0.0, fast = 0.0;
};
class ControllerRigBase : public Rig {
 public:
  virtual Rumble rumble() = 0;
};
std::unique_ptr<ControllerRigBase> controller_rig();

}  // namespace palpa
