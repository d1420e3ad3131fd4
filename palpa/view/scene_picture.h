// A picture of a scene: its layers, the paths of probe and proxy, the primitives of one moment.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "palpa/scene/scene.h"
#include "palpa/tick/session.h"
#include "palpa/view/picture.h"

namespace palpa {

/// One point of what was felt, in the hand frame.
struct PathPoint {
  Vec3 probe_m;
  Vec3 proxy_m;
  Vec3 force_n;
};

/// The primitives of one sub-step, to be drawn: a plane as a disc with its normal, a line as a rod, a
/// point as a ball, a directed force as an arrow; and the pull of the spring between proxy and probe.
struct Moment {
  Vec3 probe_m;
  Vec3 proxy_m;
  std::vector<PlacedPrimitive> primitives;
  std::vector<std::string> mode_names;  ///< by PrimitiveId::mode, for the legend
};

struct ScenePictureOptions {
  int width_px = 1200;
  int height_px = 900;
  /// Where the camera is seen from, in the hand frame; the default looks as the user does, a little from
  /// above and the right.
  Vec3 from{0.45, 0.35, 1.0};
  Vec3 up{0.0, 1.0, 0.0};
  /// Half the height of what is seen [hand m]; 0: everything fits.
  double half_height_m = 0.0;
  /// What the camera looks at [hand m]; none: the middle of what is shown.
  std::optional<Vec3> centre_m{};
};

/// Draws the scene's layers (where it names none: its first scalar field as a surface or slices, its first
/// vector field as streamlines), the path coloured by force, the moment's primitives, a scale bar in
/// millimetres of the data's world, a colour bar in newtons, and L/R A/P S/I marks in a medical frame.
/// Needs no X. The same input gives the same bytes on one machine. Throws LoadError where nothing can be
/// drawn (no EGL).
Picture scene_picture(const Scene& scene, std::span<const PathPoint> path, const std::optional<Moment>& moment,
                      const ScenePictureOptions& options = {});

}  // namespace palpa
