// Stores larger than memory for Python: preparation, and chunks as arrays.
#pragma once

#include <pybind11/pybind11.h>

namespace palpa::python {

void bind_store(pybind11::module_& module);

}  // namespace palpa::python
