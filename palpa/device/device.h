// A device: a snapshot in, a force out, and its limits.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "palpa/solver/vec3.h"

namespace palpa {

/// What a device may be asked for.
struct DeviceLimits {
  double max_force_n = 10.0;
  bool has_motors = true;  ///< false: nothing holds a force on the hand; what is let through is seen, and steers
  double max_stiffness_n_per_m = 1e5;
  double workspace_radius_m = 0.15;
  double encoder_step_m = 0.0;                                          ///< 0: none
  double continuous_force_n = std::numeric_limits<double>::infinity();  ///< that its motors bear for ever
  double max_damping_ns_per_m = std::numeric_limits<double>::infinity();
  double damping_ns_per_m = 0.0;  ///< of its own mechanics
};

/// The device at one moment, in the hand frame.
struct DeviceState {
  Vec3 position_m;
  std::optional<Vec3> velocity_m_per_s;  ///< none: the device does not measure it
  bool valid = false;                    ///< position can be used
  std::uint32_t buttons = 0;
  double time_s = 0.0;
  const char* fault = nullptr;  ///< a literal: why no force can be felt or the position not be used; none: all is well
};

/// A haptic device, or what stands for one. `read` and `write` are called from one thread, never
/// allocate, lock, throw or block: a device whose exchange takes time has a thread of its own for it (latest.h).
///
/// It is one device from construction to destruction, by its serial number, path or id. While that one is gone, `fault` says
/// so, no other is touched in its place, its buttons are up, and what it steers is at rest. It comes back by itself when it
/// can, with no force and no button held, as one that was just opened.
class Device {
 public:
  virtual ~Device() = default;  ///< leaves the motors at zero force
  virtual std::string name() const = 0;
  virtual DeviceLimits limits() const = 0;
  virtual DeviceState read() noexcept = 0;
  /// Holds `force_n` on the hand until the next write. False: the link is lost.
  virtual bool write(const Vec3& force_n) noexcept = 0;
  /// Holds the handle by its shorted motors, in place of any force, until it is told otherwise. False: it has no such brake.
  /// As `read` and `write`.
  virtual bool brake(bool /*on*/) noexcept { return false; }
  /// Whether the motors themselves have no force: they were given none since the last one was written, or are gone. False:
  /// they may have one, or it is not known. Any thread; only reads atomic values, since a signal handler waits for it
  /// (`DrivenDevice`).
  virtual bool rests() const noexcept { return false; }
};

/// A device that lives on a simulated clock: time passes when it is told so.
class SimulatedDevice : public Device {
 public:
  /// Lets `time_step_s` [s] pass under the force last written. Never allocates or throws.
  virtual void advance(double time_step_s) noexcept = 0;
  /// How long it has something to show [s]; infinite for a hand that goes on for ever.
  virtual double duration_s() const noexcept = 0;
};

}  // namespace palpa
