// Runs, replays, comparisons of laws and live scenes for Python.
#pragma once

#include <pybind11/pybind11.h>

namespace palpa::python {

void bind_study(pybind11::module_& module);
void bind_live(pybind11::module_& module);

}  // namespace palpa::python
