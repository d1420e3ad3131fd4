// Pickling of data, scenes and ticks, for the processes of a pool.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "palpa/scene/scene.h"

namespace palpa::python {

/// The volume, whose formulas are pickled by this name and arguments. With the interpreter's lock, as the others.
Volume of_formula(const std::string& name, std::vector<double> arguments, Volume volume);
/// Lets the grids of a volume that was read be pickled by its request, instead of by their voxels.
void remember_files(const Volume& volume);
/// Both, for the volumes of a scene that was loaded.
void remember_sources(const Scene& scene);

/// After the classes that are pickled.
void bind_pickling(pybind11::module_& module);

}  // namespace palpa::python
