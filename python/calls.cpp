#include "calls.h"

#include <string>
#include <unordered_map>

namespace palpa::python {

namespace py = pybind11;

namespace {

using Call = PyObject* (*)(PyObject*, PyObject*, PyObject*);

/// Description of a function, by its pybind11 capsule, for the process's lifetime. With the interpreter's lock.
struct Known {
  std::string called;  ///< "Session.tick"
  std::string doc;     ///< its first line is the signature
  bool has_self = false;
};
struct Calls {
  std::unordered_map<PyObject*, Known> known;
  Call dispatch = nullptr;  // pybind11's, of all functions
};
Calls& calls() {
  static auto* const all = new Calls;
  return *all;
}

/// Calls the function; raises a one-sentence error if its values match no signature.
PyObject* called(PyObject* self, PyObject* given, PyObject* named) {
  PyObject* const result = calls().dispatch(self, given, named);
  if (result || !PyErr_ExceptionMatches(PyExc_TypeError)) return result;
  py::error_already_set error;
  const auto known = calls().known.find(self);
  try {
    const auto words = py::str(error.value()).cast<std::string>();
    if (known == calls().known.end() || words.find("incompatible ") == std::string::npos) {
      error.restore();
      return nullptr;
    }
    const auto& [name, doc, has_self] = known->second;
    const py::tuple all = py::reinterpret_borrow<py::tuple>(given);
    const py::object without_self = all[py::slice(has_self ? 1 : 0, static_cast<py::ssize_t>(all.size()), 1)];
    const py::dict keywords = named ? py::reinterpret_borrow<py::dict>(named) : py::dict();
    const py::object sentence = py::module_::import("palpa._calls").attr("sentence")(name, doc, without_self, keywords);
    PyErr_SetObject(PyExc_TypeError, sentence.ptr());
  } catch (py::error_already_set& another) {
    another.restore();
  }
  return nullptr;
}

void tell_of(const std::string& name, py::handle function, bool has_self) {
  if (function && PyInstanceMethod_Check(function.ptr())) function = PyInstanceMethod_GET_FUNCTION(function.ptr());
  if (!function || !PyCFunction_Check(function.ptr())) return;
  const py::handle self = PyCFunction_GET_SELF(function.ptr());
  if (!self || !py::isinstance<py::capsule>(self)) return;
  PyMethodDef* const definition = reinterpret_cast<PyCFunctionObject*>(function.ptr())->m_ml;
  const auto mine = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&called));
  if (definition->ml_meth == mine) return;
  calls().dispatch = reinterpret_cast<Call>(reinterpret_cast<void (*)()>(definition->ml_meth));
  calls().known[self.ptr()] = {name, definition->ml_doc ? definition->ml_doc : "", has_self};
  definition->ml_meth = mine;
}

py::dict members_of(py::handle thing) { return py::module_::import("builtins").attr("dict")(thing.attr("__dict__")); }

}  // namespace

void tell_of_wrong_calls(py::module_& module) {
  for (const auto& [key, thing] : members_of(module)) {
    const auto name = key.cast<std::string>();
    if (!py::isinstance<py::type>(thing)) {
      tell_of(name, thing, false);
      continue;
    }
    for (const auto& [member, method] : members_of(thing)) {
      const auto of_class = member.cast<std::string>();
      const bool is_special = of_class.starts_with("__") && of_class != "__init__" && of_class != "__call__";
      if (is_special) continue;
      if (py::isinstance(method, reinterpret_cast<PyObject*>(&PyProperty_Type))) {
        tell_of(name + "." + of_class + " =", method.attr("fset"), true);
      } else {
        tell_of(of_class == "__init__" ? name : of_class == "__call__" ? name + "()" : name + "." + of_class, method, true);
      }
    }
  }
}

}  // namespace palpa::python
