// Module palpa._palpa, the base of the package palpa (python/palpa).
#include <pybind11/pybind11.h>

#include <string>

#include "calls.h"
#include "modes.h"
#include "own_device.h"
#include "palpa/base/load_error.h"
#include "palpa/mode/plugin.h"
#include "palpa/scene/scene.h"
#include "palpa/version.h"
#include "parameters.h"
#include "pickling.h"
#include "scene.h"
#include "session.h"
#include "store.h"
#include "study.h"

namespace palpa::python {

// The name equals the file's. Order: bases before their users.
PYBIND11_MODULE(_palpa, module) {
  module.attr("version") = version;
  if (constexpr detail::PluginAbi own = detail::plugin_abi(); own != detail::library_abi()) {
    throw py::import_error(
        std::string("palpa: this module was made with the headers of another libpalpa than was loaded (it is of ") + version +
        "); install both anew");
  }
  const py::object load_error = py::register_exception<LoadError>(module, "LoadError", PyExc_ValueError);
  py::register_exception<SceneError>(module, "SceneError", load_error);
  bind_parameters(module);
  bind_scene(module);
  bind_modes(module);
  bind_session(module);
  bind_study(module);
  bind_store(module);
  bind_pickling(module);
  bind_devices(module);
  bind_live(module);
  tell_of_wrong_calls(module);
}

}  // namespace palpa::python
