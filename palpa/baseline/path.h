// The path of earlier systems: one step per tick.
#pragma once

#include <memory>

#include "palpa/tick/session.h"

namespace palpa::baseline {

/// For `Session(scene, baseline::path)`: the path of the law that the scene names in `[law] method`. The exact law has that of
/// docs/path.md. All earlier systems moved the proxy once per frame: one step per tick, from where the proxy is straight to the
/// balance, stopping nowhere. Modes are told afterwards what it went through; they look at the data at the proxy or, for
/// no-proxy, at the probe. Allocates; throws SceneError on a name that is none.
std::unique_ptr<ProxyPath> path(LiveBlock& live, const Scene& scene, const Similarity& hand_to_world);

/// For `Session(scene, baseline::one_step)`: the exact balance once per tick, whatever law the scene names. This is what is
/// left of an earlier system when its solver is blameless: it shows that it is the path, and not the balance, that a difference
/// comes from. Allocates and throws SceneError.
std::unique_ptr<ProxyPath> one_step(LiveBlock& live, const Scene& scene, const Similarity& hand_to_world);

}  // namespace palpa::baseline
