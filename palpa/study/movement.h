// Hand paths as functions of time: in to a front, over it, at rest on it, through it; and their runs.
#pragma once

#include <functional>
#include <memory>

#include "palpa/device/front.h"
#include "palpa/device/hand.h"
#include "palpa/study/felt.h"
#include "palpa/study/summary.h"

namespace palpa {

/// Speed of all slides: an exploring hand.
inline constexpr double slide_m_per_s = 0.05;

/// Path as a function of time [s].
std::shared_ptr<const Target> path_target(std::function<Vec3(double)> at, double duration_s);
/// Hand over the front at a constant speed.
struct HandSlide {
  std::shared_ptr<const Target> target;
  double from_s = 0.0, to_s = 0.0;  ///< interval of constant speed
};
/// Path in to a depth [m] behind the front, and over it in a direction that is `turn` [1] of a full turn from the right,
/// `beside_m` to the left of the place.
HandSlide slide_over(const Encounter& met, double turn, double beside_m, double depth_m);
/// Start [s] of the rest (with tremor) of a hand from `hold_at`.
inline constexpr double even_s = 2.4;
struct Tremor {
  double amplitude_m = 0.0;
  double frequency_hz = 10.0;
};
/// Path in to the depth [m], `beside_m` to the right of the place, then rest with a tremor along the user's axis.
std::shared_ptr<const Target> hold_at(const Encounter& met, double beside_m, double depth_m, const Tremor& tremor,
                                      double duration_s);

/// Runs a device in a scene, at 1 kHz on a simulated clock.
/// \param summary  collects the run's numbers as well; or nullptr
FeltRun feel(const Scene& scene, SimulatedDevice& device, double duration_s, SummaryBuilder* summary = nullptr);

}  // namespace palpa
