// Calls that fit no signature, told in one sentence.
#pragma once

#include <pybind11/pybind11.h>

namespace palpa::python {

/// From here on a call of one of the module's functions, methods, constructors or setters with values that fit none of its
/// signatures raises TypeError with the sentence of `palpa._calls`, in place of pybind11's list of C++ types. A call that fits
/// costs nothing more. After everything else is bound.
void tell_of_wrong_calls(pybind11::module_& module);

}  // namespace palpa::python
