// Parameter lists of a scene's parts for Python: values by name, and their descriptions.
#pragma once

#include <pybind11/numpy.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "palpa/mode/mode.h"
#include "palpa/scene/keys.h"
#include "palpa/scene/scene.h"

namespace palpa::python {

namespace py = pybind11;

/// Object with a list of parameters, which outlives its Python object. With the interpreter's lock.
class Part {
 public:
  virtual ~Part() = default;
  virtual void visit(ParameterVisitor& visitor) = 0;
  /// Calls `change` with a part whose visitors may change values and which may be renewed: this, or a copy that replaces it in
  /// its scene afterwards, if it is valid.
  virtual void edit(const std::function<void(Part&)>& change) { change(*this); }
  /// Resets to defaults. A visitor can only fill lists and optional values, not clear them.
  virtual void renew() {}
};
using PartPtr = std::shared_ptr<Part>;

/// Part that somebody else owns.
inline PartPtr borrowed(Part& part) {
  return {&part, [](Part*) {}};
}

/// Struct with a list.
template <class T>
class StructPart final : public Part {
 public:
  explicit StructPart(T value) : value_(std::move(value)) {}
  void visit(ParameterVisitor& visitor) override { detail::visit_parameters(value_, visitor); }
  void renew() override { value_ = T{}; }
  const T& value() const { return value_; }

 private:
  T value_;
};

/// Coupling, workspace, time or tool of a scene.
template <class T>
class OptionsPart final : public Part {
 public:
  using Get = const T& (Scene::*)() const noexcept;
  OptionsPart(std::shared_ptr<Scene> scene, Get get) : scene_(std::move(scene)), get_(get) {}
  const T& value() const { return ((*scene_).*get_)(); }
  void visit(ParameterVisitor& visitor) override { StructPart<T>(value()).visit(visitor); }
  void edit(const std::function<void(Part&)>& change) override {
    scene_->edit<T>([&](T& options) {
      StructPart<T> part(options);
      change(part);
      options = part.value();
    });
  }

 private:
  std::shared_ptr<Scene> scene_;
  Get get_;
};

/// Mode outside of a scene.
class ModePart final : public Part {
 public:
  explicit ModePart(Mode mode) : mode_(std::move(mode)) {}
  void visit(ParameterVisitor& visitor) override { mode_.visit(visitor); }
  void renew() override;
  const Mode& mode() const { return mode_; }

 private:
  Mode mode_;
};

/// Mode of a scene, by its name; raises KeyError once removed.
class SceneModePart final : public Part {
 public:
  SceneModePart(std::shared_ptr<Scene> scene, std::string name) : scene_(std::move(scene)), name_(std::move(name)) {}
  void visit(ParameterVisitor& visitor) override { look_through(mode().mode, visitor); }
  void edit(const std::function<void(Part&)>& change) override;
  const SceneMode& mode() const;

 private:
  std::shared_ptr<Scene> scene_;
  std::string name_;
};

/// Types of modes for Python: built-in and of plug-ins.
ModeCatalog& known_modes();

/// Value of a parameter: float, int, bool, str, tuple, Strength, None, or a list of parts. Raises AttributeError.
py::object value_of(const PartPtr& part, std::string_view name);
/// Values of all parameters by name: items of lists as dicts, without their left-out values.
py::dict values_of(const PartPtr& part);
/// Sets a parameter; None removes or resets it. Raises AttributeError on an unknown name, TypeError and ValueError on a wrong
/// value.
void set_value(Part& part, std::string_view name, py::handle value);

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
/// Array of numbers, or a list, as floats in C's order; NaN if masked. None if it holds no numbers.
std::optional<Numbers> numbers_of(py::handle given);
/// Numbers of shape (n, 3), or (n,) for `columns` = 1; TypeError that names `name` for other shapes.
Numbers rows_of(py::handle given, std::string_view name, py::ssize_t columns);
/// Time step [s], above 0 and at most 1; ValueError or TypeError with its name on anything else.
double time_step_of(py::handle given);

/// Numbers of a sequence; none if it holds others, or is a text.
std::optional<std::vector<double>> maybe_numbers(py::handle value);
/// Python number; TypeError with `name` on anything else.
double number_of(py::handle value, std::string_view name);
Vec3 vector_of(py::handle value, std::string_view name);
/// Four numbers (w, x, y, z); TypeError with `name` on anything else.
Turn turn_of(py::handle value, std::string_view name);
py::array_t<double> array_of(const Vec3& v);
py::array_t<double> array_of(const Turn& turn);  ///< w, x, y, z

/// Descriptions of the keys: (name, annotation, form, fallback, sentence, keys of its items or None).
py::list described(const detail::Keys& keys);

void bind_parameters(py::module_& module);

}  // namespace palpa::python
