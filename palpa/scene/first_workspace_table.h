// Workspace table of a first scene: direction of the user, reach, and a close-up.
#pragma once

#include <string>

#include "palpa/data/volume.h"
#include "palpa/scene/first_volume_table.h"

namespace palpa::detail {

/// Direction towards the user, and its reason.
struct Facing {
  std::string towards_user, up;
  std::string why_towards_user, why_up;
  Vec3 towards_m;  ///< [1] that direction in the world
};
/// \param size_m      of the object
/// \param lying_at_y  [1] position along y, from -1 to 1, of the solid outside of the object; 0: none
Facing facing_of(const Volume& volume, bool is_flow, const Vec3& size_m, double lying_at_y);

/// Close-up of a part of the data.
struct CloseUp {
  Vec3 centre_m;
  double side_m = 0.0;
  std::string what;
};

/// \param felt    for a field in octaves, the hand's metres of their voxels
/// \param cell_m  [m] resolution of the object's box
std::string workspace_table(const Volume& volume, const Field& felt, const SceneNames& names, const Box& object_m,
                            const Facing& facing, const CloseUp& close, double cell_m);

}  // namespace palpa::detail
