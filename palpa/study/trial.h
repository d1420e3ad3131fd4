// A hand tried out in a scene, and how good it was.
#pragma once

#include <memory>

#include "palpa/device/hand.h"
#include "palpa/study/summary.h"

namespace palpa::detail {

/// What a hand feels in the first `longest_s` [s], by running it. Allocates; throws SceneError.
Summary tried(const Scene& scene, std::shared_ptr<const Target> target, Hold hold, double longest_s);
/// The share [1] of the modes that were in contact for more than 2 % of the time.
double kinds_met(const Summary& summary);
/// Whether the guard held some of the force back in more than 0.2 % of the ticks.
bool is_often_limited(const Summary& summary);
/// How good a trial is [1], at most 2: the share of contact plus that of modes met, less what a force at its limit and a proxy
/// that lags behind cost.
double worth_of(const Summary& summary);

}  // namespace palpa::detail
