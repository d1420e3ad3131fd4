// The table of a first scene's workspace: from which side the hand comes, what it reaches, and a closer look.
#pragma once

#include <string>

#include "palpa/data/volume.h"
#include "palpa/scene/first_volume_table.h"

namespace palpa::detail {

/// From which side the hand comes, and why.
struct Facing {
  std::string towards_user, up;
  std::string why_towards_user, why_up;
  Vec3 towards_m;  ///< [1] that direction of the world
};
/// \param size_m      of the object
/// \param lying_at_y  [1] where along y, from -1 to 1, lies what is solid but no part of the object; 0: nowhere
Facing facing_of(const Volume& volume, bool is_flow, const Vec3& size_m, double lying_at_y);

/// A closer look at a part of the data.
struct CloseUp {
  Vec3 centre_m;
  double side_m = 0.0;
  std::string what;
};

/// \param cell_m  [m] to which the object's box is known
std::string workspace_table(const Volume& volume, const SceneNames& names, const Box& object_m, const Facing& facing,
                            const CloseUp& close, double cell_m);

}  // namespace palpa::detail
