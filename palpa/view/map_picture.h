// A picture of a slice through the force field of a scene.
#pragma once

#include "palpa/study/map.h"
#include "palpa/view/picture.h"

namespace palpa {

struct MapPictureOptions {
  int width_px = 1600;
  int height_px = 770;
};

/// Draws a map that is flat across one axis of the hand: side by side the force on first contact and the steady one, coloured
/// by how strong they are, with arrows for their part in the slice, the levels of the scene's modes as lines where the slice
/// cuts them, and the hand's axes in millimetres. The user is below or at the right, and before the picture of a slice across
/// z.
///
/// \param map  whole, with one point along exactly one axis, as of `map_slice`
/// Needs no X. The same input gives the same bytes on one machine. Throws LoadError where nothing can be drawn (no EGL), and on
/// a size not within 800 x 400 to 8000 x 8000 pixels.
Picture map_picture(const Scene& scene, const ForceMap& map, const MapPictureOptions& options = {});

}  // namespace palpa
