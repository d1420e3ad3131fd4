// Interface of a device's stand-in for the conformance tests (conformance_test.cpp).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "palpa/device/backend.h"

namespace palpa {

/// A stand-in for one device, from outside: the test moves its handle, pulls its plug, and measures its motors' force. Each rig
/// converts units and axes by a table from the vendor's words, not by the code under test.
class Rig {
 public:
  virtual ~Rig() = default;
  /// A new device that is connected to this stand-in.
  virtual std::unique_ptr<Device> open() = 0;
  /// Sets the handle's position [m, hand frame] and velocity [m/s]. For rate-controlled hands: the deflection; 1 is full.
  virtual void hold(const Vec3& position_m, const Vec3& velocity_m_per_s) = 0;
  /// Sets the handle's orientation [hand frame], if it senses one.
  virtual void turn(const Turn&) {}
  /// Orientation and torque of the handle.
  enum class Wrist : std::uint8_t { none, sensed, driven };
  virtual Wrist wrist() const { return Wrist::none; }
  /// The motors' present force [N, hand frame]; 0 after a watchdog of the device.
  virtual Vec3 force_n() = 0;
  /// Likewise their torque [N·m, hand frame].
  virtual Vec3 torque_nm() { return {}; }
  virtual void press_button(int number, bool down) = 0;
  virtual bool has_buttons() const { return true; }
  virtual void unplug() = 0;
  virtual void plug() = 0;

  /// Plugs in another device of the kind, of an equal model where the driver can distinguish two: the device that a driver by
  /// index, or of any device, would take. It is fully deflected, with button 0 held.
  virtual void plug_another() = 0;
  virtual void unplug_another() = 0;
  /// Repeats its deflection and button, for devices that send changes only.
  virtual void use_another() {}
  /// True if it was opened or its motors got a command.
  virtual bool is_another_touched() = 0;

  struct Fault {
    std::string name;
    std::function<void()> begin, end;
  };
  /// Ways of removal and return: unplugged, or with its daemon.
  virtual std::vector<Fault> ways_to_go() {
    return {{"unplugged", [this] { unplug(); }, [this] { plug(); }}};
  }
  /// Ways of removal of an attached handle with buttons. Button 0 is one of them.
  virtual std::vector<Fault> ways_of_a_handle_to_go() { return {}; }
  /// Further faults: while a fault lasts, the device reports it by `fault` or is invalid.
  virtual std::vector<Fault> faults() { return {}; }
  /// The largest error of a position by the device's own units [m] (numbers of bits, of digits).
  virtual double position_step_m() const { return 1e-9; }
  /// Rate of its orientations; the driver walks between slow ones.
  virtual double turn_rate_hz() const { return 1000.0; }
};

struct NamedRig {
  std::string name;
  std::string backend;  ///< of the kind's shared object; empty: it has none
  std::function<std::unique_ptr<Rig>()> make;
  bool is_steered = false;  ///< no motors; a process can have one
  bool has_place = false;   ///< position control, no rate control
};
inline void PrintTo(const NamedRig& rig, std::ostream* out) { *out << rig.name; }
/// At least one per kind of device, in rigs.cpp.
std::vector<NamedRig> rigs();

/// Opens a device as a program does, without a user's limits.
std::unique_ptr<Device> opened(const std::string& backend, const DeviceSettings& settings);

}  // namespace palpa
