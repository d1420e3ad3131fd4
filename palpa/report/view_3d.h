// JSON for view_3d.js, the interactive view of a report: layers, paths, events, moments.
#pragma once

#include <string>
#include <vector>

#include "palpa/report/moments.h"
#include "palpa/scene/scene.h"

namespace palpa::detail {

struct View3dOptions {
  std::size_t most_triangles = 60'000;   ///< of all surfaces
  std::size_t most_path_points = 3'000;  ///< of probe and proxy each
  std::size_t most_events = 400;         ///< marks in the view
};

/// Layers, path, events and moments for view_3d.js; of a tool also feet, orientations and torques for tool.js.
/// \param scene    nullptr: no data, so no layers, and no feet of a tool
/// \param moments  in order; may have no primitives
/// \param from     [1] initial direction to the viewer, hand frame
std::string json_of_view(const Recorded& recorded, const Scene* scene, const std::vector<RecordedMoment>& moments,
                         const Vec3& from, const View3dOptions& options = {});

}  // namespace palpa::detail
