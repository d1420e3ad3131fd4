// Scene files and recorded hands of bench_path.
#pragma once

#include <palpa/scene/scene.h>
#include <palpa/session/session.h>

#include <utility>

#include "bench/path.h"
#include "tests/path/scenes.h"

namespace palpa::bench {

/// The selected scene files, default all of the folder; without a data folder no scenes of real data.
std::vector<std::string> scene_files(const PathOptions& options);
std::string short_name(const std::string& file);
/// A scene with some of its numbers set (`--set`).
Scene load_still(const std::string& file, const PathOptions& options,
                 const std::vector<std::pair<std::string, std::string>>& sets = {});
/// Probes of a firm hand in this scene, tick by tick: a recording of wood carving, or without data a simulated stroke; at most
/// `seconds`, 0: all.
std::vector<Probe> recorded_probes(const std::string& file, const PathOptions& options, double seconds);

}  // namespace palpa::bench
