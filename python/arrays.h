// Arrays of numpy as voxels.
#pragma once

#include <pybind11/numpy.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "palpa/data/volume.h"
#include "palpa/solver/vec3.h"

namespace palpa::python {

/// Returns the position after the vector.
inline double* put(double* to, const Vec3& v) noexcept {
  to[0] = v.x, to[1] = v.y, to[2] = v.z;
  return to + 3;
}

/// Python object, kept by a thread that need not have the interpreter's lock.
std::shared_ptr<const void> kept(pybind11::object object, const void* data);

/// Position of an array's voxels.
struct PlacedArray {
  Mat3 steps_m = Mat3::identity();  ///< [m] columns: steps from voxel to voxel along the array's x, y, z (its last axis first)
  std::optional<Vec3> origin_m{};   ///< [m] of the voxel [0, 0, 0]; none: the array is centred at the world's origin
  std::optional<std::array<std::vector<double>, 3>> planes_m{};  ///< [m] along x, y, z, in place of both: of a rectilinear grid
};

/// Volume of one field that reads the array in place. Raises ValueError or TypeError, one line.
/// \param array  indexed [z, y, x], or [z, y, x, component] for vectors
/// \param copy   copy an array that cannot be read in place
Volume array_volume(const pybind11::object& array, const PlacedArray& placed, const std::string& unit, bool copy);

/// Voxels of a field on a grid as stored, before scale and offset: a read-only view, indexed [k, j, i] or [k, j, i, component].
pybind11::array raw_voxels_of(const FieldPtr& field);
/// Voxels of a field on a grid, indexed [z, y, x] or [z, y, x, component], read-only, without a copy unless scaled; None for
/// other fields.
pybind11::object voxels_of(const FieldPtr& field);
/// Matrix of an affine map, shape (4, 4).
pybind11::array_t<double> matrix_of(const Mat3& linear, const Vec3& origin_m);
pybind11::array_t<double> matrix_of(const Similarity& map);
/// Matrix from indices of those voxels (x, y, z) to world positions, shape (4, 4); None if there is none.
pybind11::object affine_of(const Field& field);

/// Values and gradients at many positions.
pybind11::tuple sample(const Field& field, const pybind11::object& points_m);

}  // namespace palpa::python
