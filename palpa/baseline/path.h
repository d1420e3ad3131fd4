// The path of earlier systems: one step per tick.
#pragma once

#include <memory>

#include "palpa/session/session.h"

namespace palpa::baseline {

/// For `Session(scene, baseline::path)`: the path of the law that the scene names in `[law] method`. The exact law has that of
/// docs/path.md. All earlier systems moved the proxy once per frame: one step per tick, straight from the proxy to the balance,
/// without a stop. Modes are told afterwards which levels the proxy crossed; they read the data at the proxy or, for no-proxy,
/// at the probe. Allocates; throws SceneError on an unknown name.
std::unique_ptr<ProxyPath> path(StateArena& live, const Scene& scene, const Similarity& hand_to_world);

/// For `Session(scene, baseline::one_step)`: the exact balance once per tick, whatever law the scene names. This is an earlier
/// system with an exact solver: what then still differs from the exact law's path comes from the path, not from the balance.
/// Allocates; throws SceneError.
std::unique_ptr<ProxyPath> one_step(StateArena& live, const Scene& scene, const Similarity& hand_to_world);

}  // namespace palpa::baseline
