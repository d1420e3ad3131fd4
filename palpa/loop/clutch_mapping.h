// How the device's handle holds the probe: camera, clutch, and the way on beyond the border of its workspace.
#pragma once

#include "palpa/device/device.h"
#include "palpa/session/session.h"

namespace palpa {

/// The probe is where the handle is, turned as the view is and put further by what the clutch and the border did:
///     probe = turn · handle + offset
/// A length at the hand is a length at the probe, so k and D are those at the hand whatever the view. Pure on told time;
/// allocates nothing; one thread.
class ClutchMapping {
 public:
  struct Options {
    double workspace_radius_m = 0.15;  ///< > 0: of the device
    std::uint32_t clutch_buttons = 0;  ///< while one of these is held the handle moves and the probe does not; 0: no clutch
    bool goes_on_at_border = false;    ///< a handle at the border of its workspace takes the probe further (rate control)
  };
  explicit ClutchMapping(const Options& options) noexcept : options_(options) {}

  /// How the view lies: a device's direction is this times it in the hand frame of the scene. A rotation; anything else is
  /// left out. What is felt begins anew after it.
  void turn(const Mat3& turn) noexcept;
  struct Held {
    Probe probe;
    bool moves = false;  ///< the clutch or the view moves: nothing may be felt
  };
  /// \param time_step_s  [s] > 0
  Held hold(const DeviceState& state, double time_step_s) noexcept;
  /// A force in the hand frame of the scene [N] as the device has to make it.
  Vec3 at_device(const Vec3& force_n) const noexcept;

 private:
  Options options_;
  Mat3 turn_ = Mat3::identity();
  Vec3 offset_m_;
  Vec3 probe_m_;  // last
  bool has_probe_ = false;
  bool turned_ = false;
};

}  // namespace palpa
