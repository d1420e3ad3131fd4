// Options of a run or a live scene.
#pragma once

#include <pybind11/pybind11.h>

#include "palpa/study/run.h"

namespace palpa::python {

/// Options from keywords; None keeps the default. Raises TypeError and ValueError.
RunOptions run_options(const pybind11::dict& given);
/// Scene as if loaded from its TOML.
LoadedScene loaded_of(const Scene& scene);

}  // namespace palpa::python
