// What every kind of device is held to, by a stand-in for the device itself: the laws are in conformance_test.cpp.
#pragma once

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "palpa/device/device.h"

namespace palpa {

/// A stand-in for one device, as seen from the outside: the test moves its handle, pulls its plug, and measures the force that
/// its motors make. Each rig converts to and from the device's own units and axes by a table of its own, from the vendor's
/// words, and not by the code under test.
class Rig {
 public:
  virtual ~Rig() = default;
  /// A new device that is connected to this stand-in.
  virtual std::unique_ptr<Device> open() = 0;
  /// Puts the handle there [m, hand frame] at that velocity [m/s]. For rate-controlled hands: deflects it, 1 is all the way.
  virtual void hold(const Vec3& position_m, const Vec3& velocity_m_per_s) = 0;
  /// The force [N, hand frame] that the motors make now; what a watchdog of the device switched off is zero.
  virtual Vec3 force_n() = 0;
  virtual void press_button(int number, bool down) = 0;
  virtual void unplug() = 0;
  virtual void plug() = 0;

  struct Fault {
    std::string name;
    std::function<void()> begin, end;
  };
  /// What else can go wrong with it: while a fault lasts the device must say so by `fault`, or not be valid.
  virtual std::vector<Fault> faults() { return {}; }
  /// The largest error of a position by the device's own units [m] (numbers of bits, of digits).
  virtual double position_step_m() const { return 1e-9; }
};

struct NamedRig {
  std::string name;
  std::function<std::unique_ptr<Rig>()> make;
  bool is_steered = false;  ///< no motors and no place of its own; a process can have one
};
inline void PrintTo(const NamedRig& rig, std::ostream* out) { *out << rig.name; }
/// One per kind of device, in rigs.cpp.
std::vector<NamedRig> rigs();

}  // namespace palpa
