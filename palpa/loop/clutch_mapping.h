// Mapping of the device's handle to the probe: view rotation, clutch, and rate control at the workspace's border.
#pragma once

#include "palpa/device/device.h"
#include "palpa/guard/wrench.h"
#include "palpa/session/session.h"

namespace palpa {

/// Probe position: the handle's, rotated with the view and shifted by clutch and border:
///     probe = turn · handle + offset
/// A length at the hand is a length at the probe, so k and D hold at the hand in any view. The orientation is rotated with the
/// view as well, so that the tool is seen as it is held; clutch and border leave it to the handle. Depends on its arguments
/// only; allocates nothing; one thread.
class ClutchMapping {
 public:
  struct Options {
    double workspace_radius_m = 0.15;  ///< > 0: of the device
    std::uint32_t clutch_buttons = 0;  ///< while one of these is held the handle moves the offset, not the probe; 0: no clutch
    bool goes_on_at_border = false;    ///< a handle at the border of its workspace moves the probe on (rate control)
  };
  explicit ClutchMapping(const Options& options) noexcept : options_(options) {}

  /// Sets the rotation of the view: from the device's axes to the scene's hand frame. Ignores any other matrix. Contact
  /// restarts after it.
  void turn(const Mat3& turn) noexcept;
  struct Held {
    Probe probe;
    bool moves = false;  ///< the clutch or the view moves: no force allowed
  };
  /// \param time_step_s  [s] > 0
  Held hold(const DeviceState& state, double time_step_s) noexcept;
  /// Rotates force and torque in the hand frame of the scene to the device's axes.
  Wrench at_device(const Wrench& wrench) const noexcept;

 private:
  Options options_;
  Mat3 turn_ = Mat3::identity();
  Turn quaternion_;  // of `turn_`
  Vec3 offset_m_;
  Vec3 probe_m_;  // last position
  bool has_probe_ = false;
  bool turned_ = false;
};

}  // namespace palpa
