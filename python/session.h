// Sessions for Python: one tick at a time, or a whole path of the hand.
#pragma once

#include <pybind11/pybind11.h>

#include <span>

#include "palpa/solver/law.h"

namespace palpa::python {

/// Primitives as dicts, for `Session.primitives` and `Live.primitives`.
pybind11::list primitives_of(std::span<const PlacedPrimitive> placed);

void bind_session(pybind11::module_& module);

}  // namespace palpa::python
