// What Python sees of the parts of a scene that have lists of parameters: values by name, and what the lists say of them.
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

/// Something that has a list of parameters, and outlives the Python object that looks at it. With the interpreter's lock.
class Part {
 public:
  virtual ~Part() = default;
  virtual void visit(ParameterVisitor& visitor) = 0;
  /// Back to its defaults. Lists and what may be left out can only be filled, not emptied, by a visitor.
  virtual void renew() = 0;
};
using PartPtr = std::shared_ptr<Part>;

/// A struct of a scene with a list: its coupling, workspace, …
template <class T>
class MemberPart final : public Part {
 public:
  explicit MemberPart(std::shared_ptr<T> member) : member_(std::move(member)) {}
  void visit(ParameterVisitor& visitor) override { detail::visit_parameters(*member_, visitor); }
  void renew() override { *member_ = T{}; }
  T& value() { return *member_; }

 private:
  std::shared_ptr<T> member_;
};

/// A mode that is nobody's yet.
class ModePart final : public Part {
 public:
  explicit ModePart(Mode mode) : mode_(std::move(mode)) {}
  void visit(ParameterVisitor& visitor) override { mode_.visit(visitor); }
  void renew() override;
  Mode& mode() { return mode_; }

 private:
  Mode mode_;
};

/// A mode of a scene, by its name; raises KeyError once it is taken away.
class SceneModePart final : public Part {
 public:
  SceneModePart(std::shared_ptr<Scene> scene, std::string name) : scene_(std::move(scene)), name_(std::move(name)) {}
  void visit(ParameterVisitor& visitor) override { mode().mode.visit(visitor); }
  void renew() override;
  SceneMode& mode();

 private:
  std::shared_ptr<Scene> scene_;
  std::string name_;
};

/// The types of modes that Python knows: those that Palpa brings, and those of plug-ins.
ModeCatalog& known_modes();

/// The value of a parameter: float, int, bool, str, tuple, Strength, None, or a list of parts. Raises AttributeError.
py::object value_of(const PartPtr& part, std::string_view name);
/// Sets it; None leaves it out, or at its default. Raises AttributeError on an unknown name, TypeError and ValueError on what
/// it cannot be.
void set_value(Part& part, std::string_view name, py::handle value);

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
/// An array of numbers as floats, in C's order, or one made of a list; NaN where it is masked. None where it holds no numbers.
std::optional<Numbers> numbers_of(py::handle given);
/// Numbers of shape (n, 3), or (n,) for `columns` = 1; TypeError that names `name` for other shapes.
Numbers rows_of(py::handle given, std::string_view name, py::ssize_t columns);
/// A time step [s], above 0 and at most 1; ValueError or TypeError with its name in it on anything else.
double time_step_of(py::handle given);

/// A number of Python's; TypeError with `name` in it on anything else.
double number_of(py::handle value, std::string_view name);
/// Three of them.
Vec3 vector_of(py::handle value, std::string_view name);
/// A vector as an array of Python's.
py::array_t<double> array_of(const Vec3& v);

/// What Python knows of each key: (name, annotation, form, fallback, sentence, keys of its items or None).
py::list described(const detail::Keys& keys);

void bind_parameters(py::module_& module);

}  // namespace palpa::python
