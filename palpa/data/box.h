// Boxes along the axes: what two have in common, and which ways may meet one.
#pragma once

#include <algorithm>

#include "palpa/data/field.h"

namespace palpa {

/// What lies in both; where nothing does, its low corner is beyond its high one.
inline Box intersection(const Box& a, const Box& b) noexcept {
  return {{std::max(a.low_m.x, b.low_m.x), std::max(a.low_m.y, b.low_m.y), std::max(a.low_m.z, b.low_m.z)},
          {std::min(a.high_m.x, b.high_m.x), std::min(a.high_m.y, b.high_m.y), std::min(a.high_m.z, b.high_m.z)}};
}

/// False only where no point of the straight way between two places [m] is in the box: the box around the way misses it.
inline bool may_meet(const Box& box, const Vec3& from_m, const Vec3& to_m) noexcept {
  const auto overlaps = [](double low, double high, double a, double b) {
    return std::max(a, b) >= low && std::min(a, b) <= high;
  };
  return overlaps(box.low_m.x, box.high_m.x, from_m.x, to_m.x) && overlaps(box.low_m.y, box.high_m.y, from_m.y, to_m.y) &&
         overlaps(box.low_m.z, box.high_m.z, from_m.z, to_m.z);
}

}  // namespace palpa
