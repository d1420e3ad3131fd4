// Device: its state as input, a force as output, and its limits.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "palpa/solver/pose.h"

namespace palpa {

/// Limits of a device.
struct DeviceLimits {
  double max_force_n = 10.0;
  bool has_motors = true;  ///< false: no force on the hand; it is displayed, and steers a simulated position
  double max_stiffness_n_per_m = 1e5;
  double workspace_radius_m = 0.15;
  double encoder_step_m = 0.0;                                          ///< 0: none
  double continuous_force_n = std::numeric_limits<double>::infinity();  ///< that its motors can hold permanently
  double max_damping_ns_per_m = std::numeric_limits<double>::infinity();
  double damping_ns_per_m = 0.0;  ///< of its own mechanics
  bool senses_turn = false;       ///< reports the orientation of its handle
  double max_torque_nm = 0.0;     ///< about its point; 0: it drives no torque
  double max_turn_stiffness_nm_per_rad = std::numeric_limits<double>::infinity();
  double max_turn_damping_nms_per_rad = std::numeric_limits<double>::infinity();
};

/// State of a device at a moment, in the hand frame.
struct DeviceState {
  Vec3 position_m;
  std::optional<Vec3> velocity_m_per_s;  ///< none: not measured
  bool valid = false;                    ///< position can be used
  std::uint32_t buttons = 0;
  double time_s = 0.0;
  const char* fault = nullptr;  ///< string literal: why there is no force or valid position; nullptr: no fault
  /// Orientation of the handle, of unit length, no rotation in its reference pose (docs/devices.md); none: not sensed.
  std::optional<Turn> turn{};
};

/// Haptic device, or a substitute. `read` and `write` are called from one thread and never allocate, lock, throw or block: a
/// device with slow communication uses a thread of its own for it (latest.h).
///
/// Bound to one physical device for its lifetime, by serial number, path or id. While that device is disconnected, `fault` is
/// set, no other device is opened, buttons read as released, and a rate-controlled position stands still. It reconnects
/// automatically if possible, with zero force and no button pressed, as if just opened.
class Device {
 public:
  virtual ~Device() = default;  ///< leaves the motors at zero force
  virtual std::string name() const = 0;
  virtual DeviceLimits limits() const = 0;
  virtual DeviceState read() noexcept = 0;
  /// Holds `force_n` on the hand until the next write. False: the link is lost.
  virtual bool write(const Vec3& force_n) noexcept = 0;
  /// Likewise with `torque_nm` about the device's point; without motors for it the force alone.
  virtual bool write(const Vec3& force_n, const Vec3& /*torque_nm*/) noexcept { return write(force_n); }
  /// Brakes the handle by shorting its motors, in place of any force, until called with false. Returns false if it has no such
  /// brake. Call from the thread of `read` and `write`.
  virtual bool brake(bool /*on*/) noexcept { return false; }
  /// True if the motors certainly exert no force: zero was sent after the last force written, or they are disconnected. False:
  /// they may exert one. Any thread; reads atomic values only, since a signal handler polls it (`DrivenDevice`).
  virtual bool rests() const noexcept { return false; }
};

/// Device on a simulated clock: time passes by `advance`.
class SimulatedDevice : public Device {
 public:
  /// Advances by `time_step_s` [s] under the force last written. Never allocates or throws.
  virtual void advance(double time_step_s) noexcept = 0;
  /// Duration of its motion [s]; infinite for endless motion.
  virtual double duration_s() const noexcept = 0;
};

}  // namespace palpa
