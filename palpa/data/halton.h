// Places spread evenly over a box.
#pragma once

#include "palpa/data/field.h"

namespace palpa::detail {

/// The digits of `index` to a base, mirrored at the point: 0…1. The base is known when it is compiled,
/// as a division by anything is many times as slow (J. H. Halton, Numer. Math. 2, 1960).
template <int base>
double radical_inverse(int index) noexcept {
  double value = 0.0, digit = 1.0 / base;
  for (; index > 0; index /= base, digit /= base) value += digit * (index % base);
  return value;
}

/// The place [m] of number `index`, from 1 on, of Halton's sequence over a box: the first n cover it evenly, whatever n is.
inline Vec3 halton(int index, const Box& box) noexcept {
  const Vec3 size_m = box.size_m();
  return box.low_m +
         Vec3{radical_inverse<2>(index) * size_m.x, radical_inverse<3>(index) * size_m.y, radical_inverse<5>(index) * size_m.z};
}

}  // namespace palpa::detail
