// Strengths and masks for Python: functions of a field's value.
#pragma once

#include <pybind11/pybind11.h>

namespace palpa::python {

void bind_strengths(pybind11::module_& module);

}  // namespace palpa::python
