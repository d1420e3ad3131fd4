// Force Dimension's and 3D Systems' devices on stand-ins for their libraries.
#pragma once

#include <cstdint>
#include <memory>

#include "tests/devices/rig.h"

namespace palpa {

class ForceDimensionRigBase : public Rig {
 public:
  virtual bool brakes() = 0;
};
enum class DhdLibrary : std::uint8_t { whole, by_index };  ///< by index: it opens no device by its serial number
std::unique_ptr<ForceDimensionRigBase> force_dimension_rig(DhdLibrary library = DhdLibrary::whole,
                                                           Rig::Wrist wrist = Rig::Wrist::none);

class OpenHapticsRigBase : public Rig {
 public:
  virtual void warm(double share) = 0;  ///< [1] temperature of its motors
  virtual void take_gimbal() = 0;       ///< a model with three encoders; before it is opened
};
std::unique_ptr<OpenHapticsRigBase> openhaptics_rig();

}  // namespace palpa
