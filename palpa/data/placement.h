// Place and orientation of a volume's grid in its world.
#pragma once

#include <array>
#include <string>

#include "palpa/data/grid.h"
#include "palpa/data/volume.h"

namespace palpa {

/// Where the grid of a volume lies in its world.
struct Placement {
  GridGeometry grid;                   ///< of the first field
  Vec3 spacing_m;                      ///< [m] length of one step along i, j, k
  Vec3 size_m;                         ///< [m] from the first to the last voxel's far sides, along i, j, k
  std::array<std::string, 3> towards;  ///< the direction nearest to each axis: "the patient's left", "+x"
  std::string letters;                 ///< "LPS" in a medical frame, "+x +y +z" elsewhere
  double oblique_deg = 0.0;            ///< the largest angle between an axis and its nearest direction
  double sheared_deg = 0.0;            ///< the largest deviation from a right angle between two axes
  bool mirrored = false;               ///< i, j, k are left-handed in the world
};

/// Placement of a volume whose first field is a grid. Allocates; any thread.
Placement placement_of(const Volume& volume);

}  // namespace palpa
