// A device that nobody holds, and how stiff a scene can be before it hums by itself.
#pragma once

#include <functional>
#include <memory>

#include "palpa/device/hand.h"
#include "palpa/scene/scene.h"

namespace palpa {

/// A device without a hand: its own mass, damping and Coulomb friction, pushed by one constant force (its weight, a finger that
/// rests on it) and by the rendered force, which acts `delay_ticks` late and is held between writes. Integrated in 100
/// sub-steps per `advance`, each by backward Euler. `plant.mass_kg` must be above 0. It measures no velocity and never ends.
/// \param start_m  [m] where it begins, at rest
/// \param push_n   [N] the constant force
std::unique_ptr<SimulatedDevice> let_go(const DevicePlant& plant, const Vec3& start_m, const Vec3& push_n);

/// A device that is let go on a wall, to see whether it comes to rest.
struct LetGoOptions {
  DevicePlant plant;
  double damping_ns_per_m = 0.0;  ///< D of the coupling
  double push_n = 0.5;            ///< constant force with which it lies on the wall, > 0
  double start_depth_m = 0.0003;  ///< it begins this much deeper than where it would rest
  bool tells_encoder = true;      ///< whether the session knows the encoder's step
  double rate_hz = 1000.0;        ///< of the loop, > 0
};
/// Whether it is at rest after two seconds, or on its way there: in the last half second it moves by no more than its encoder
/// can tell, or less than in the half second before.
bool comes_to_rest(const LetGoOptions& options, double stiffness_n_per_m);

/// The largest stiffness [N/m] between `low_n_per_m` and `high_n_per_m` up to which `is_stable` holds, to one part in 100, by
/// bisection of their ratio; 0 if it does not hold at the lowest. \param low_n_per_m  [N/m] > 0
double largest_stable_stiffness_n_per_m(const std::function<bool(double)>& is_stable, double low_n_per_m, double high_n_per_m);

}  // namespace palpa
