// Picture of a slice through the force field of a scene.
#pragma once

#include "palpa/study/map.h"
#include "palpa/view/picture.h"

namespace palpa {

struct MapPictureOptions {
  int width_px = 1600;
  int height_px = 770;
};

/// Draws a map that is flat along one axis of the hand: side by side the force on first contact and the steady force, coloured
/// by magnitude, with arrows for the components in the slice, the levels of the scene's modes as contour lines, and the hand's
/// axes in millimetres. The user is below or at the right, and in front of a slice across z.
///
/// \param map  complete, with one point along exactly one axis, as of `map_slice`
/// Needs no X. Equal input gives equal bytes on one machine. Throws LoadError without EGL, and on a size not within 800 x 400
/// to 8000 x 8000 pixels.
Picture map_picture(const Scene& scene, const ForceMap& map, const MapPictureOptions& options = {});

}  // namespace palpa
