// A hand tried out in a scene, and how good it was.
#pragma once

#include <memory>

#include "palpa/device/hand.h"
#include "palpa/study/summary.h"

namespace palpa::detail {

/// What a hand feels, tried out for a while.
Summary tried(const Scene& scene, std::shared_ptr<const Target> target, Hold hold, double longest_s);
/// The share [1] of the modes that were met for more than a moment.
double kinds_met(const Summary& summary);
/// How good that is: contact, with all modes that there are, a force that is rarely at its limit, and a proxy that follows.
double worth_of(const Summary& summary);

}  // namespace palpa::detail
