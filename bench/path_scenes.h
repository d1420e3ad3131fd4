// Scene files and recorded hands for the parts of bench_path.
#pragma once

#include <palpa/scene/scene.h>
#include <palpa/session/session.h>

#include <utility>

#include "bench/path.h"
#include "tests/path/scenes.h"

namespace palpa::bench {

/// The scene files asked for: all of the folder, without those of real data where there is no folder of data.
std::vector<std::string> scene_files(const PathOptions& options);
std::string short_name(const std::string& file);
/// A scene with some of its numbers set (`--set`).
Scene load_still(const std::string& file, const PathOptions& options,
                 const std::vector<std::pair<std::string, std::string>>& sets = {});
/// Where a firm hand's probe is, tick by tick, in this scene: along a recording of wood carving, or, without data, along
/// a simulated stroke; `seconds` at most, 0: all.
std::vector<Probe> recorded_probes(const std::string& file, const PathOptions& options, double seconds);

}  // namespace palpa::bench
