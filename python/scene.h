// Scenes, volumes and fields for Python.
#pragma once

#include <pybind11/pybind11.h>

namespace palpa::python {

void bind_scene(pybind11::module_& module);

}  // namespace palpa::python
