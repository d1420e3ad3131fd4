// Where in the world a hand that knows nothing of the data has something to feel.
#pragma once

#include <functional>

#include "palpa/field/field.h"

namespace palpa::detail {

/// A cube of the world that becomes the hand's reach.
struct Reach {
  Vec3 centre_m;
  double side_m = 0.0;
  double share = 0.0;  ///< [1] of its middle, a cube half as wide, that is the object
  bool whole = true;   ///< as wide as the longest side of the box, about its centre
};

/// All of the box where its middle has at least the share `wanted` [1] of object; else the largest cube that has it in its
/// middle, where a hand moves most; of several as large, the fullest. Cubes are looked for on a lattice of 48 cells along the
/// longest side, and what lies outside of the box is no object. Where there is none, the fullest of those a fifth as wide.
Reach reach_with(const Box& box, const std::function<bool(const Vec3&)>& is_object, double wanted);

/// The first place of the object that is met on the straight way from the border of the box into the reach's centre, coming
/// from the direction `towards_user` [1], a unit vector; the centre itself where all of the way or none of it is object.
Vec3 surface_before(const Reach& reach, const Box& box, const Vec3& towards_user,
                    const std::function<bool(const Vec3&)>& is_object);

}  // namespace palpa::detail
