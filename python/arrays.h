// Arrays of numpy as voxels.
#pragma once

#include <pybind11/numpy.h>

#include "palpa/core/vec3.h"
#include "palpa/volume/volume.h"

namespace palpa::python {

/// An object of Python's, kept by a thread that need not have the interpreter's lock.
std::shared_ptr<const void> kept(pybind11::object object, const void* data);

/// A volume of one field that reads the array where it is. Raises ValueError or TypeError, one line.
/// \param array      indexed [z, y, x], or [z, y, x, component] for vectors
/// \param spacing_m  [m] between voxels along x, y, z
/// \param origin_m   [m] of the voxel [0, 0, 0]; None: the middle of the array lies in the world's origin
/// \param copy       take a copy where the array cannot be read as it is
Volume array_volume(const pybind11::object& array, const Vec3& spacing_m, const pybind11::object& origin_m,
                    const std::string& unit, bool copy);

/// Values and gradients at many places.
pybind11::tuple sample(const Field& field, const pybind11::object& points_m);

}  // namespace palpa::python
