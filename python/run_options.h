// What a run or a live scene is asked for.
#pragma once

#include <pybind11/pybind11.h>

#include "palpa/study/run.h"

namespace palpa::python {

/// From keywords; those that are None are left as they are by default. Raises TypeError and ValueError.
RunOptions run_options(const pybind11::dict& given);
/// A scene as if it were loaded from what it is in TOML.
LoadedScene loaded_of(const Scene& scene);

}  // namespace palpa::python
