// Released device, and the largest stiffness of a scene at which it does not hum.
#pragma once

#include <functional>
#include <memory>

#include "palpa/device/hand.h"
#include "palpa/scene/scene.h"

namespace palpa {

/// Device without a hand: its own mass, damping and Coulomb friction, pushed by a constant force (its weight, a resting finger)
/// and by the rendered force, which acts `delay_ticks` late and is held between writes. Integrated in 100 sub-steps per
/// `advance`, each by backward Euler. Measures no velocity and never ends.
class ReleasedDevice : public SimulatedDevice {
 public:
  /// [J] Work of the rendered force on the device so far. A passive loop takes energy, and gives back no more than it took:
  /// above 0, and above the energy of modes that drive, the loop drives the device.
  virtual double work_j() const noexcept = 0;
};
/// \param plant    with a mass above 0
/// \param start_m  [m] initial position, at rest
/// \param push_n   [N] the constant force
std::unique_ptr<ReleasedDevice> released_device(const DevicePlant& plant, const Vec3& start_m, const Vec3& push_n);

/// Test of a released device on a wall for rest.
struct ReleasedDeviceOptions {
  DevicePlant plant;
  double damping_ns_per_m = 0.0;  ///< D of the coupling
  double push_n = 0.5;            ///< constant force onto the wall, > 0
  double start_depth_m = 0.0003;  ///< initial depth below its rest position
  bool uses_encoder = true;       ///< the session uses the encoder's step
  double rate_hz = 1000.0;        ///< of the loop, > 0
  double rest_steps = 1.5;        ///< [1] encoder steps of a swing at rest; 3.5: toggles of a stable loop are no hum
};
/// Whether the device is at rest after two seconds, or converging: in the last half second it moves by no more than
/// `rest_steps`, or less than in the half second before.
bool comes_to_rest(const ReleasedDeviceOptions& options, double stiffness_n_per_m);

/// Largest stiffness [N/m] between `low_n_per_m` and `high_n_per_m` up to which `is_stable` holds, to one part in 100, by
/// bisection of their ratio; 0 if it does not hold at the lowest. \param low_n_per_m  [N/m] > 0
double largest_stable_stiffness_n_per_m(const std::function<bool(double)>& is_stable, double low_n_per_m, double high_n_per_m);

}  // namespace palpa
