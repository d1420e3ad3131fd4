// Turns from rotation matrices.
#pragma once

#include <algorithm>
#include <cmath>

#include "palpa/solver/pose.h"

namespace palpa {

/// Whether rows and determinant of `matrix` are those of a rotation to within `tolerance` [1]; false for values that are not
/// finite. Allocates nothing; any thread.
inline bool is_rotation(const Mat3& matrix, double tolerance) noexcept {
  bool is_so = std::abs(determinant(matrix) - 1.0) <= tolerance;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j)
      is_so = is_so && std::abs(dot(matrix.row[i], matrix.row[j]) - (i == j ? 1.0 : 0.0)) <= tolerance;
  return is_so;
}

/// Turn of a rotation matrix, of unit length; of the identity no rotation to the bit. From the largest of the four components
/// (Shepperd 1978), so that no division is by a small number. Allocates nothing; any thread.
/// \param rotation  see `is_rotation`
inline Turn turn_of(const Mat3& rotation) noexcept {
  const auto& r = rotation.row;
  const double trace = r[0].x + r[1].y + r[2].z;
  Turn made;
  if (trace >= std::max({r[0].x, r[1].y, r[2].z}))
    made = {1.0 + trace, r[2].y - r[1].z, r[0].z - r[2].x, r[1].x - r[0].y};
  else if (r[0].x >= std::max(r[1].y, r[2].z))
    made = {r[2].y - r[1].z, 1.0 + r[0].x - r[1].y - r[2].z, r[0].y + r[1].x, r[0].z + r[2].x};
  else if (r[1].y >= r[2].z)
    made = {r[0].z - r[2].x, r[0].y + r[1].x, 1.0 - r[0].x + r[1].y - r[2].z, r[1].z + r[2].y};
  else
    made = {r[1].x - r[0].y, r[0].z + r[2].x, r[1].z + r[2].y, 1.0 - r[0].x - r[1].y + r[2].z};
  return unit_turn(made);
}

}  // namespace palpa
