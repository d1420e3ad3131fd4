// One-sentence errors for calls that match no signature.
#pragma once

#include <pybind11/pybind11.h>

namespace palpa::python {

/// Makes calls of the module that match no signature raise TypeError with the sentence of `palpa._calls` in place of pybind11's
/// list of C++ types. Matching calls cost nothing more. Call after all bindings.
void tell_of_wrong_calls(pybind11::module_& module);

}  // namespace palpa::python
