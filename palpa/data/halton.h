// Halton's sequence over a box.
#pragma once

#include "palpa/data/field.h"

namespace palpa::detail {

/// Digits of `index` to a base, mirrored at the point: 0…1. The base is a template argument because division by a variable is
/// many times as slow (J. H. Halton, Numer. Math. 2, 1960).
template <int base>
double radical_inverse(int index) noexcept {
  double value = 0.0, digit = 1.0 / base;
  for (; index > 0; index /= base, digit /= base) value += digit * (index % base);
  return value;
}

/// Point [m] number `index` >= 1 of Halton's sequence over a box: any first n points cover it evenly.
inline Vec3 halton(int index, const Box& box) noexcept {
  const Vec3 size_m = box.size_m();
  return box.low_m +
         Vec3{radical_inverse<2>(index) * size_m.x, radical_inverse<3>(index) * size_m.y, radical_inverse<5>(index) * size_m.z};
}

}  // namespace palpa::detail
