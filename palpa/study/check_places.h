// Worst places of a scene for a device: strongest, most curved, most uneven.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "palpa/device/hand.h"
#include "palpa/scene/scene.h"

namespace palpa {

/// Place for trials of a device.
struct CheckPlace {
  std::string why;               ///< "strongest", "most curved", "most uneven", "middle"
  Vec3 front_m;                  ///< start of contact
  Vec3 inwards{0.0, 0.0, -1.0};  ///< [1] of length 1: against the largest force, if that is towards the user
  double force_n = 0.0;          ///< largest force of all modes on the path in from there
  double turn_n = 0.0;           ///< largest change of their force by rotation in a millimetre of that path
  double uneven_n = 0.0;         ///< largest change of it in a millimetre beyond the coupling's
  Encounter met;                 ///< with its fronts; `depth_m` is that of a rigid hand
  double deeper_n = 0.0;         ///< additional push of an arm for that depth
};

/// [N/m] Stiffness of the coupling on the sampled paths, that of first scenes. One for all scenes: places and directions that
/// depend on the scene's own stiffness compare different places, and a stiffer scene may seem better. Higher: fewer paths get
/// deep below the force limit; lower: levels hold a probe far behind them.
inline constexpr double sampling_stiffness_n_per_m = 500.0;

/// Samples the whole workspace along straight paths from the user, at `sampling_stiffness_n_per_m` instead of the scene's
/// stiffness, and selects places without repetition: at least one if there is any contact, else none. On all cores.
/// Deterministic.
/// \param spacing_m  [m] between paths, in [0.005, 0.05]
/// \param progress   called with the share done, 0…1, from this thread; may be empty
/// Throws SceneError on a scene that cannot be felt.
std::vector<CheckPlace> check_places(const Scene& scene, double spacing_m, const std::function<void(double)>& progress = {});

}  // namespace palpa
