// Where a scene is worst for a device: where it is strongest, most curved, most uneven.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "palpa/device/hand.h"
#include "palpa/scene/scene.h"

namespace palpa {

/// A place of a scene that a device is tried at.
struct CheckPlace {
  std::string why;               ///< "strongest", "most curved", "most uneven", "middle"
  Vec3 front_m;                  ///< where it begins to be felt
  Vec3 inwards{0.0, 0.0, -1.0};  ///< [1] of length 1: against the largest force, if that is towards the user
  double force_n = 0.0;          ///< the largest force of all modes on the way in from there
  double turn_n = 0.0;           ///< the most by which their force turned in a millimetre of that way
  double uneven_n = 0.0;         ///< the most by which it changed in a millimetre beyond what the coupling makes of that
  Encounter met;                 ///< with the fronts around it; `depth_m` is what a hand held by no arm reaches
  double deeper_n = 0.0;         ///< what an arm has to push besides to come as deep
};

/// Feels the whole of the hand's workspace along straight ways from the user, and chooses places, none twice: at least one
/// where anything is felt, else none. In as many threads as there are processors. The same scene gives the same places.
/// \param spacing_m  [m] between ways, in [0.005, 0.05]
/// \param progress   called with the share that is done, 0…1, from this thread; may be empty
/// Throws SceneError on a scene that cannot be felt.
std::vector<CheckPlace> check_places(const Scene& scene, double spacing_m, const std::function<void(double)>& progress = {});

}  // namespace palpa
