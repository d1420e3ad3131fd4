#include "palpa/device/open_device.h"
#include "tests/devices/igtl_rig.h"
#include "tests/devices/inverse3_rig.h"
#include "tests/devices/rig.h"
#include "tests/devices/steered_rigs.h"
#include "tests/devices/vendor_rigs.h"

namespace palpa {

std::vector<NamedRig> rigs() {
  return {{"Inverse3", "inverse3", inverse3_rig},
          {"ForceDimension", "force-dimension", [] { return std::unique_ptr<Rig>(force_dimension_rig()); }},
          {"ForceDimensionByIndex", "force-dimension",
           [] { return std::unique_ptr<Rig>(force_dimension_rig(DhdLibrary::by_index)); }},
          {"ForceDimensionWithWrist", "force-dimension",
           [] { return std::unique_ptr<Rig>(force_dimension_rig(DhdLibrary::whole, Rig::Wrist::sensed)); }},
          {"ForceDimensionWithTorque", "force-dimension",
           [] { return std::unique_ptr<Rig>(force_dimension_rig(DhdLibrary::whole, Rig::Wrist::driven)); }},
          {"OpenHaptics", "openhaptics", [] { return std::unique_ptr<Rig>(openhaptics_rig()); }},
          {"SpaceMouse", "spacemouse", spacemouse_rig, true},
          {"Controller", "controller", [] { return std::unique_ptr<Rig>(controller_rig()); }, true},
          {"Tracker", "igtl", igtl_rig, true, true},
          {"MouseHand", "", pointer_rig, true, true}};
}

}  // namespace palpa
