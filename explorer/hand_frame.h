// Frames of a scene's hands in the window, whose own is the first hand's.
#pragma once

#include <cstddef>

#include "palpa/scene/scene.h"

namespace palpa::explorer {

/// Origin of a hand's frame in the window's [m]; the axes are equal.
/// \param hand  below the number of hands, or 0
inline Vec3 frame_origin_m(const Scene& scene, std::size_t hand) {
  return scene.hands().empty() ? Vec3{} : scene.hands()[hand].at_m - scene.hands().front().at_m;
}

}  // namespace palpa::explorer
