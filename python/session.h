// Sessions for Python: one tick at a time, or a whole path of the hand.
#pragma once

#include <pybind11/pybind11.h>

namespace palpa::python {

void bind_session(pybind11::module_& module);

}  // namespace palpa::python
