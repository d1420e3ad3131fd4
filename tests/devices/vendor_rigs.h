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
std::unique_ptr<ForceDimensionRigBase> force_dimension_rig(DhdLibrary library = DhdLibrary::whole);

class OpenHapticsRigBase : public Rig {
 public:
  virtual void warm(double share) = 0;  ///< [1] temperature of its motors
};
std::unique_ptr<OpenHapticsRigBase> openhaptics_rig();

}  // namespace palpa
