// What every kind of device is held to, by a stand-in for the device itself: the laws are in conformance_test.cpp.
#pragma once

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "palpa/device/backend.h"

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

  /// Plugs in another device of the kind, of the same model where the driver can tell two of a model apart: the one that a
  /// driver comes upon that counts, or that takes whatever is there. It is deflected all the way, and its button 0 is held.
  virtual void plug_another() = 0;
  virtual void unplug_another() = 0;
  /// Its deflection and button once more, for devices that say them when they change only.
  virtual void use_another() {}
  /// Whether it was opened, or anything was said to its motors.
  virtual bool is_another_touched() = 0;

  struct Fault {
    std::string name;
    std::function<void()> begin, end;
  };
  /// How the device can go, and come back: pulled out, or with the program that brings it.
  virtual std::vector<Fault> ways_to_go() {
    return {{"unplugged", [this] { unplug(); }, [this] { plug(); }}};
  }
  /// How what is beside the device, and has buttons, can go: a handle of its own. Button 0 is one of its.
  virtual std::vector<Fault> ways_of_a_handle_to_go() { return {}; }
  /// What else can go wrong with it: while a fault lasts the device must say so by `fault`, or not be valid.
  virtual std::vector<Fault> faults() { return {}; }
  /// The largest error of a position by the device's own units [m] (numbers of bits, of digits).
  virtual double position_step_m() const { return 1e-9; }
};

struct NamedRig {
  std::string name;
  std::string backend;  ///< of the kind's shared object; empty: it has none
  std::function<std::unique_ptr<Rig>()> make;
  bool is_steered = false;  ///< no motors; a process can have one
  bool has_place = false;   ///< it is steered by places, and not by a speed
};
inline void PrintTo(const NamedRig& rig, std::ostream* out) { *out << rig.name; }
/// At least one per kind of device, in rigs.cpp.
std::vector<NamedRig> rigs();

/// Opens a device as a program does, without a user's limits.
std::unique_ptr<Device> opened(const std::string& backend, const DeviceSettings& settings);

}  // namespace palpa
