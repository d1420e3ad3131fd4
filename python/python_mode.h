// Modes written in Python.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>
#include <vector>

#include "palpa/mode/mode.h"
#include "palpa/mode/parameters.h"

namespace palpa::python {

/// Fields that a mode reads, by their names in the mode.
struct ReadFields {
  std::vector<std::pair<std::string, FieldRef>> fields;

  explicit ReadFields(const std::vector<std::pair<std::string, std::string>>& names = {}) {
    for (const auto& [key, name] : names) fields.emplace_back(key, FieldRef{name});
  }
  void visit(ParameterKind kind, ParameterVisitor& visitor) {
    for (auto& [name, ref] : fields) {
      visitor.field({.name = name, .sentence = "a field that the mode reads", .kind = kind, .needed = true}, ref);
    }
  }
};

bool is_in_python(const Mode& mode) noexcept;
/// The object of a mode in Python; None for other modes. With the interpreter's lock.
pybind11::object python_object_of(const Mode& mode);
/// Mode with its name in the scene: a Python mode needs it for its exceptions.
Mode named(const Mode& mode, const std::string& name);

void bind_python_modes(pybind11::module_& module);

}  // namespace palpa::python
