// Viewpoint and extent of a picture, in the hand frame.
#pragma once

#include "palpa/solver/vec3.h"

namespace palpa::detail {

/// Parallel projection of the hand frame onto a picture.
struct View {
  Vec3 centre_m;        ///< centre of the picture
  Vec3 right{1, 0, 0};  ///< unit vectors in the hand frame: the picture's right and up, and to the viewer
  Vec3 up{0, 1, 0};
  Vec3 towards{0, 0, 1};
  double half_height_m = 0.1;
  int width_px = 0;
  int height_px = 0;

  double px_per_m() const noexcept { return 0.5 * height_px / half_height_m; }
  /// Pixels from the left and from the bottom.
  double x_px(const Vec3& p_m) const noexcept { return 0.5 * width_px + px_per_m() * dot(p_m - centre_m, right); }
  double y_px(const Vec3& p_m) const noexcept { return 0.5 * height_px + px_per_m() * dot(p_m - centre_m, up); }
};

}  // namespace palpa::detail
