// Damper, spring and plane in a closed loop with a device: largest stable stiffness, noise.
#pragma once

#include "palpa/device/hand.h"
#include "palpa/solver/vec3.h"

namespace palpa::test {

/// A device in a hand, pressed against a plane through the origin, at 1 kHz and with one tick of delay besides the device's
/// own.
struct ClosedLoop {
  DevicePlant plant;
  Arm arm{.mass_kg = 0.0, .damping_ns_per_m = 0.0, .stiffness_n_per_m = 0.0};  ///< default: no hand
  bool friction = false;  ///< the device's Coulomb friction, which hides the damper's effect
  bool told = true;       ///< the damper has the encoder step
  double stiffness_n_per_m = 500.0;
  double damping_ns_per_m = 1.0;
  Vec3 normal{0.0, 0.0, 1.0};   ///< of the plane; unit
  double push_n = 1.0;          ///< push besides the arm's, towards the plane
  double speed_m_per_s = 0.05;  ///< at contact with the plane
};

struct LoopFelt {
  double swing_m = 0.0;  ///< largest less smallest distance from the plane in the last second
  double noise_n = 0.0;  ///< root of the mean square of the command from 20 to 500 Hz in the last second
};
LoopFelt felt_in(const ClosedLoop& loop, double duration_s = 8.0);

/// The largest stiffness [N/m], in steps of 25 up to 2000, below which every loop comes to rest: swings by at most 12 encoder
/// steps in the last of 8 s, at slow and fast contact, axial and oblique.
double largest_stable_stiffness(ClosedLoop loop);

}  // namespace palpa::test
