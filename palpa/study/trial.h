// Trial of a hand in a scene, and its worth.
#pragma once

#include <memory>

#include "palpa/device/hand.h"
#include "palpa/study/summary.h"

namespace palpa::detail {

/// Runs a hand for its first `longest_s` [s]. Allocates; throws SceneError.
Summary tried(const Scene& scene, std::shared_ptr<const Target> target, Hold hold, double longest_s);
/// [1] Share of the time from which a mode counts as met. More: small objects never count; less: a touch by chance does.
inline constexpr double some_contact = 0.02;
/// Share [1] of the modes that were met.
double kinds_met(const Summary& summary);
/// Whether the guard limited the force in more than 0.2 % of the ticks.
bool is_often_limited(const Summary& summary);
/// Worth of a trial [1], at most 2: the share of contact plus that of modes met, minus penalties for a force at its limit and a
/// lagging proxy.
double worth_of(const Summary& summary);

}  // namespace palpa::detail
