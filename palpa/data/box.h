// Axis-aligned boxes: intersection, and a conservative segment test.
#pragma once

#include <algorithm>

#include "palpa/data/field.h"

namespace palpa {

/// Intersection; if empty, its low corner is beyond its high corner.
inline Box intersection(const Box& a, const Box& b) noexcept {
  return {{std::max(a.low_m.x, b.low_m.x), std::max(a.low_m.y, b.low_m.y), std::max(a.low_m.z, b.low_m.z)},
          {std::min(a.high_m.x, b.high_m.x), std::min(a.high_m.y, b.high_m.y), std::min(a.high_m.z, b.high_m.z)}};
}

/// False only if no point of the segment between two positions [m] is in the box: the segment's bounding box misses it.
inline bool may_meet(const Box& box, const Vec3& from_m, const Vec3& to_m) noexcept {
  const auto overlaps = [](double low, double high, double a, double b) {
    return std::max(a, b) >= low && std::min(a, b) <= high;
  };
  return overlaps(box.low_m.x, box.high_m.x, from_m.x, to_m.x) && overlaps(box.low_m.y, box.high_m.y, from_m.y, to_m.y) &&
         overlaps(box.low_m.z, box.high_m.z, from_m.z, to_m.z);
}

}  // namespace palpa
