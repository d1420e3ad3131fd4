#include "tests/devices/inverse3_rig.h"
#include "tests/devices/rig.h"
#include "tests/devices/steered_rigs.h"
#include "tests/devices/vendor_rigs.h"

namespace palpa {

std::vector<NamedRig> rigs() {
  return {{"Inverse3", inverse3_rig},
          {"ForceDimension", [] { return std::unique_ptr<Rig>(force_dimension_rig()); }},
          {"OpenHaptics", [] { return std::unique_ptr<Rig>(openhaptics_rig()); }},
          {"SpaceMouse", spacemouse_rig, true},
          {"Controller", [] { return std::unique_ptr<Rig>(controller_rig()); }, true}};
}

}  // namespace palpa
