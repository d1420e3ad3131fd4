#include "parameters.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "palpa/base/wording.h"
#include "palpa/mode/plugin.h"
#include "palpa/scene/parts.h"
#include "strengths.h"

namespace palpa::python {
namespace {

using Visit = std::function<void(ParameterVisitor&)>;

detail::Keys keys_of(const Visit& visit) {
  detail::Keys keys;
  detail::KeyCollector collector(keys);
  visit(collector);
  return keys;
}

/// Python annotation of a value's type.
std::string annotation_of(const detail::Key& key, ParameterKind kind) {
  std::string type;
  switch (kind) {
    case ParameterKind::number:
    case ParameterKind::level: type = "float"; break;
    case ParameterKind::optional_number: type = key.choices.empty() ? "float | None" : "float | str | None"; break;
    case ParameterKind::whole_number: type = key.fallback.empty() ? "int | None" : "int"; break;
    case ParameterKind::flag: type = "bool"; break;
    case ParameterKind::choice:
      for (const std::string& choice : key.choices) type += (type.empty() ? "Literal['" : "', '") + choice;
      type += "']";
      break;
    case ParameterKind::text:
    case ParameterKind::volume:
    case ParameterKind::scalar_field:
    case ParameterKind::vector_field:
    case ParameterKind::optional_field: type = "str"; break;
    case ParameterKind::strength: type = "float | Strength"; break;
    case ParameterKind::vector:
    case ParameterKind::numbers: type = "Sequence[float] | None"; break;
    case ParameterKind::vectors: type = "Sequence[Sequence[float]]"; break;
    case ParameterKind::whole_numbers: type = "Sequence[int] | None"; break;
    case ParameterKind::texts: type = "Sequence[str]"; break;
    case ParameterKind::list: type = "list"; break;
    case ParameterKind::named_tables:
    case ParameterKind::table: type = "dict"; break;
    case ParameterKind::rows: type = "Sequence"; break;
  }
  return type;
}

std::string annotation_of(const detail::Key& key) {
  return annotation_of(key, key.kind) + (key.or_kind ? " | " + annotation_of(key, *key.or_kind) : "");
}

std::string type_name(py::handle value) { return value.get_type().attr("__name__").cast<std::string>(); }

[[noreturn]] void refuse_type(std::string_view name, const std::string& takes, py::handle value) {
  throw py::type_error(detail::in_quotes(name) + " takes " + takes + ", not " + type_name(value));
}

std::optional<std::int64_t> whole_number_of(py::handle value) {
  if (PyBool_Check(value.ptr()) || !PyIndex_Check(value.ptr())) return {};
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!number) throw py::error_already_set();
  int overflow = 0;
  const long long result = PyLong_AsLongLongAndOverflow(number.ptr(), &overflow);
  if (overflow != 0) return {};
  return result;
}

std::optional<double> maybe_number(py::handle value) {
  if (PyFloat_Check(value.ptr())) return PyFloat_AS_DOUBLE(value.ptr());
  if (PyBool_Check(value.ptr()) || value.is_none()) return {};
  if (std::string_view(Py_TYPE(value.ptr())->tp_name) == "MaskedConstant") return std::numeric_limits<double>::quiet_NaN();
  const double number = PyFloat_AsDouble(value.ptr());
  if (number == -1.0 && PyErr_Occurred()) {
    if (!PyErr_ExceptionMatches(PyExc_TypeError)) throw py::error_already_set();
    PyErr_Clear();
    return {};
  }
  return number;
}

}  // namespace

std::optional<std::vector<double>> maybe_numbers(py::handle value) {
  if (py::isinstance<py::str>(value) || !PySequence_Check(value.ptr())) return {};
  std::vector<double> numbers;
  for (const py::handle item : py::reinterpret_borrow<py::object>(value)) {
    const auto number = maybe_number(item);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

namespace {

class ItemPart final : public Part {
 public:
  ItemPart(PartPtr of, std::string list, std::size_t i) : of_(std::move(of)), list_(std::move(list)), i_(i) {}
  void visit(ParameterVisitor& visitor) override;
  void edit(const std::function<void(Part&)>& change) override {
    of_->edit([&](Part& of) {
      ItemPart item(borrowed(of), list_, i_);
      change(item);
    });
  }

 private:
  PartPtr of_;
  std::string list_;
  std::size_t i_;
};

/// Skips every parameter except one list, and passes its items to another visitor.
class ListFinder final : public ParameterVisitor {
 public:
  ListFinder(std::string_view name, std::function<void(ParameterList&)> found) : name_(name), found_(std::move(found)) {}
  void number(const ParameterInfo&, double&) override {}
  void optional_number(const ParameterInfo&, std::optional<double>&) override {}
  void flag(const ParameterInfo&, bool&) override {}
  void text(const ParameterInfo&, std::string&) override {}
  void choice(const ParameterInfo&, int&) override {}
  void field(const ParameterInfo&, FieldRef&) override {}
  void strength(const ParameterInfo&, Strength&) override {}
  void list(const ParameterInfo& info, ParameterList& items) override {
    if (info.name == name_) found_(items);
  }

 private:
  std::string_view name_;
  std::function<void(ParameterList&)> found_;
};

void ItemPart::visit(ParameterVisitor& visitor) {
  bool is_there = false;
  ListFinder finder(list_, [&](ParameterList& items) {
    if (i_ >= items.size()) return;
    is_there = true;
    items.visit(i_, visitor);
  });
  of_->visit(finder);
  if (!is_there) throw py::index_error("the list '" + list_ + "' has become shorter; take its items anew");
}

class Getter final : public ParameterVisitor {
 public:
  Getter(PartPtr part, std::string_view name) : part_(std::move(part)), name_(name) {}
  void number(const ParameterInfo& info, double& value) override { take(info, py::float_(value)); }
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override { take(info, py::cast(value)); }
  void flag(const ParameterInfo& info, bool& value) override { take(info, py::bool_(value)); }
  void text(const ParameterInfo& info, std::string& value) override { take(info, py::str(value)); }
  void choice(const ParameterInfo& info, int& value) override {
    take(info, value < 0 ? py::object(py::none()) : py::str(std::string(info.choices[static_cast<std::size_t>(value)])));
  }
  void field(const ParameterInfo& info, FieldRef& ref) override { take(info, py::str(ref.name)); }
  void strength(const ParameterInfo& info, Strength& value) override {
    take(info, value.is_constant() ? py::object(py::float_(value.constant_n)) : py::cast(value));
  }
  void list(const ParameterInfo& info, ParameterList& items) override {
    py::list parts;
    for (std::size_t i = 0; i < items.size(); ++i)
      parts.append(PartPtr(std::make_shared<ItemPart>(part_, std::string(info.name), i)));
    take(info, std::move(parts));
  }
  void whole_number(const ParameterInfo& info, std::optional<std::int64_t>& value) override { take(info, py::cast(value)); }
  void numbers(const ParameterInfo& info, std::vector<double>& value) override {
    take(info, value.empty() ? py::object(py::none()) : py::tuple(py::cast(value)));
  }
  void texts(const ParameterInfo& info, std::vector<std::string>& value) override { take(info, py::tuple(py::cast(value))); }
  void vectors(const ParameterInfo& info, std::vector<Vec3>& value) override {
    py::list rows;
    for (const Vec3& v : value) rows.append(py::make_tuple(v.x, v.y, v.z));
    take(info, py::tuple(rows));
  }

  py::object result;
  bool found = false;

 private:
  /// On duplicate names, takes the parameter with a value.
  void take(const ParameterInfo& info, py::object taken) {
    if (info.name != name_) return;
    const bool says_nothing = taken.is_none() || (py::isinstance<py::str>(taken) && py::len(taken) == 0);
    if (!found || !says_nothing) result = std::move(taken);
    found = true;
  }
  PartPtr part_;
  std::string_view name_;
};

void assign(const Visit& visit, std::string_view name, py::handle value);

/// Sets a parameter; None only for an optional number. On duplicate names, sets the one whose type fits.
class Setter final : public ParameterVisitor {
 public:
  Setter(std::string_view name, py::handle value) : name_(name), value_(value) {}
  void number(const ParameterInfo& info, double& value) override {
    if (const auto number = number_for(info)) set(value, within(info, *number));
  }
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override {
    const bool is_word_for_none =
        py::isinstance<py::str>(value_) && !info.choices.empty() && value_.cast<std::string>() == info.choices.front();
    if (info.name == name_ && (value_.is_none() || is_word_for_none)) {
      value.reset(), done = true;
    } else if (const auto number = number_for(info)) {
      set(value, within(info, *number));
    }
  }
  void flag(const ParameterInfo& info, bool& value) override {
    const bool is_flag = PyBool_Check(value_.ptr()) || type_name(value_) == "bool_" || type_name(value_) == "numpy.bool";
    if (info.name == name_ && is_flag) set(value, PyObject_IsTrue(value_.ptr()) == 1);
  }
  void text(const ParameterInfo& info, std::string& value) override {
    if (const auto text = text_for(info)) set(value, info.choices.empty() ? *text : one_of(info, *text).first);
  }
  void choice(const ParameterInfo& info, int& value) override {
    if (const auto text = text_for(info)) set(value, one_of(info, *text).second);
  }
  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (const auto text = text_for(info)) set(ref, FieldRef{*text});
  }
  void strength(const ParameterInfo& info, Strength& value) override {
    if (info.name == name_ && py::isinstance<Strength>(value_)) {
      const auto strength = value_.cast<Strength>();
      for (const TransferFunction::Point& point : strength.curve.points()) within(info, point.result);
      within(info, strength.curve.outside());
      set(value, strength);
    } else if (const auto number = number_for(info)) {
      set(value, Strength(within(info, *number)));
    }
  }
  void list(const ParameterInfo& info, ParameterList& items) override {
    if (info.name != name_) return;
    if (info.kind == ParameterKind::named_tables) return named(items);
    if (!py::isinstance<py::list>(value_) && !py::isinstance<py::tuple>(value_)) return;
    for (const py::handle item : value_) append(items, item);
    done = true;
  }
  void whole_number(const ParameterInfo& info, std::optional<std::int64_t>& value) override {
    if (info.name != name_) return;
    const auto number = whole_number_of(value_);
    if (!number) return;
    if (!info.range.contains(static_cast<double>(*number))) {
      throw py::value_error(detail::in_quotes(name_) + " is " + std::to_string(*number) + "; it lies " +
                            detail::sentence_of(info.range));
    }
    set(value, number);
  }
  void numbers(const ParameterInfo& info, std::vector<double>& value) override {
    if (info.name != name_) return;
    const auto numbers = maybe_numbers(value_);
    if (!numbers) return;
    if (numbers->size() != info.count) {
      throw py::value_error(detail::in_quotes(name_) + " has " + std::to_string(numbers->size()) + " numbers; it takes " +
                            std::to_string(info.count));
    }
    for (const double each : *numbers) within(info, each);
    set(value, *numbers);
  }
  void texts(const ParameterInfo& info, std::vector<std::string>& value) override {
    if (info.name != name_ || py::isinstance<py::str>(value_) || !PySequence_Check(value_.ptr())) return;
    try {
      set(value, value_.cast<std::vector<std::string>>());
    } catch (const py::cast_error&) {  // reported as a wrong type
    }
  }
  void vectors(const ParameterInfo& info, std::vector<Vec3>& value) override {
    const auto rows = info.name == name_ ? numbers_of(value_) : std::nullopt;
    if (!rows || (rows->size() > 0 && (rows->ndim() != 2 || rows->shape(1) != 3))) return;
    std::vector<Vec3> vectors;
    for (py::ssize_t n = 0; rows->size() > 0 && n < rows->shape(0); ++n)
      vectors.push_back({within(info, rows->at(n, 0)), within(info, rows->at(n, 1)), within(info, rows->at(n, 2))});
    set(value, std::move(vectors));
  }

  bool done = false;

 private:
  template <class T, class Value>
  void set(T& member, Value&& value) {
    member = std::forward<Value>(value);
    done = true;
  }
  std::optional<double> number_for(const ParameterInfo& info) const {
    return info.name == name_ ? maybe_number(value_) : std::nullopt;
  }
  /// The number, if valid; else raises SceneError, a ValueError, as loading a scene file would.
  double within(const ParameterInfo& info, double number) const {
    if (std::isfinite(number) && info.range.contains(number)) return number;
    const std::string range = detail::sentence_of(info.range);
    throw SceneError(detail::in_quotes(name_) + " is " + detail::toml_number(number) + "; " +
                     (range.empty() ? "it is a finite number" : "it lies " + range));
  }
  std::optional<std::string> text_for(const ParameterInfo& info) const {
    if (info.name != name_ || !py::isinstance<py::str>(value_)) return {};
    return value_.cast<std::string>();
  }
  std::pair<std::string, int> one_of(const ParameterInfo& info, const std::string& text) const {
    const std::vector<std::string> words(info.choices.begin(), info.choices.end());
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (words[i] == text) return {text, static_cast<int>(i)};
    }
    throw py::value_error("no " + detail::in_quotes(name_) + " " + detail::in_quotes(text) + "; " +
                          detail::suggestion(text, words));
  }
  /// Appends an item from a dict of its parameters, or a part.
  void append(ParameterList& items, py::handle item) {
    const std::size_t i = items.size();
    items.append();
    const Visit visit = [&](ParameterVisitor& visitor) { items.visit(i, visitor); };
    if (py::isinstance<py::dict>(item)) {
      for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(item))
        assign(visit, py::str(key).cast<std::string>(), value);
    } else if (py::isinstance<Part>(item)) {
      const auto from = item.cast<PartPtr>();
      for (const detail::Key& key : keys_of(visit)) assign(visit, key.name, value_of(from, key.name));
    } else {
      refuse_type(name_, "a list of its items, each an object or a dict of its parameters", item);
    }
  }
  void named(ParameterList& items) {
    if (!py::isinstance<py::dict>(value_)) return;
    for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(value_)) {
      py::dict item;
      item["name"] = key;
      if (py::isinstance<py::dict>(value)) item.attr("update")(value);
      append(items, item);
    }
    done = true;
  }
  std::string_view name_;
  py::handle value_;
};

[[noreturn]] void refuse_name(const detail::Keys& keys, std::string_view name) {
  throw py::attribute_error("no parameter " + detail::in_quotes(name) + "; " +
                            detail::suggestion(name, detail::names_of(keys)));
}

void assign(const Visit& visit, std::string_view name, py::handle value) {
  const detail::Keys keys = keys_of(visit);
  const detail::Key* key = detail::find(keys, name);
  if (!key) refuse_name(keys, name);
  if (value.is_none() && key->kind != ParameterKind::optional_number) return;
  Setter setter(name, value);
  visit(setter);
  if (!setter.done) refuse_type(name, annotation_of(*key), value);
}

}  // namespace

void ModePart::renew() {
  if (const Mode* fresh = known_modes().find(mode_.type())) mode_ = *fresh;
}

const SceneMode& SceneModePart::mode() const {
  if (const SceneMode* mode = scene_->find_mode(name_)) return *mode;
  throw py::key_error("mode " + detail::in_quotes(name_) + " is no longer in its scene");
}

void SceneModePart::edit(const std::function<void(Part&)>& change) {
  mode();  // KeyError without one
  scene_->edit_mode(name_, [&](SceneMode& mode) {
    ModePart part(mode.mode);
    change(part);
    mode.mode = part.mode();
  });
}

ModeCatalog& known_modes() {
  static ModeCatalog modes = standard_modes();
  return modes;
}

py::object value_of(const PartPtr& part, std::string_view name) {
  Getter getter(part, name);
  part->visit(getter);
  if (!getter.found) refuse_name(keys_of([&](ParameterVisitor& visitor) { part->visit(visitor); }), name);
  return getter.result;
}

py::dict values_of(const PartPtr& part) {
  py::dict values;
  for (const detail::Key& key : keys_of([&](ParameterVisitor& visitor) { part->visit(visitor); })) {
    Getter getter(part, key.name);
    part->visit(getter);
    if (!getter.found) continue;  // of its reader and writer
    py::object value = std::move(getter.result);
    if (!key.items.empty()) {
      py::dict by_name;
      py::list copies;
      for (const py::handle item : value) {
        py::dict copy;
        for (const detail::Key& of_item : key.items) {
          const py::object of_copy = value_of(item.cast<PartPtr>(), of_item.name);
          if (!of_copy.is_none()) copy[py::str(of_item.name)] = of_copy;
        }
        if (key.kind == ParameterKind::named_tables) by_name[copy["name"]] = copy;
        copies.append(copy);
      }
      value = key.kind == ParameterKind::named_tables ? py::object(by_name) : copies;
    }
    values[py::str(key.name)] = value;
  }
  return values;
}

namespace {

void set_in(Part& part, std::string_view name, py::handle value) {
  const Visit visit = [&](ParameterVisitor& visitor) { part.visit(visitor); };
  const detail::Keys keys = keys_of(visit);
  const detail::Key* key = detail::find(keys, name);
  if (!key) refuse_name(keys, name);
  const bool empties = value.is_none() && key->kind != ParameterKind::optional_number;
  const bool refills = empties || key->or_kind || key->kind == ParameterKind::list || key->kind == ParameterKind::named_tables;
  if (!refills) return assign(visit, name, value);
  // A list is emptied by renewing the part; all other values are copied.
  const py::dict others = values_of(borrowed(part));
  const auto fill = [&](bool with_new) {
    part.renew();
    for (const auto& [other, kept] : others) {
      const std::string of = other.cast<std::string>();
      if (with_new && of == name) {
        assign(visit, name, value);
      } else if (!kept.is_none() && !(py::isinstance<py::str>(kept) && py::len(kept) == 0)) {
        assign(visit, of, kept);
      }
    }
  };
  try {
    fill(true);
  } catch (...) {
    fill(false);
    throw;
  }
}

}  // namespace

void set_value(Part& part, std::string_view name, py::handle value) {
  part.edit([&](Part& changed) { set_in(changed, name, value); });
}

double number_of(py::handle value, std::string_view name) {
  if (const auto number = maybe_number(value)) return *number;
  refuse_type(name, "a number", value);
}

std::optional<Numbers> numbers_of(py::handle given) {
  constexpr std::string_view numeric = "buifO";  // kinds of numpy types
  try {
    py::object array = py::reinterpret_borrow<py::object>(given);
    const bool is_plain = reinterpret_cast<PyObject*>(Py_TYPE(array.ptr())) ==
                          reinterpret_cast<PyObject*>(py::detail::npy_api::get().PyArray_Type_);
    if (!is_plain && py::isinstance<py::array>(array) &&
        py::module_::import("numpy").attr("ma").attr("isMaskedArray")(array).cast<bool>())
      array = array.attr("astype")("float64").attr("filled")(std::numeric_limits<double>::quiet_NaN());
    const py::array read = py::array::ensure(array);
    if (!read || numeric.find(read.dtype().kind()) == std::string_view::npos) {
      PyErr_Clear();
      return {};
    }
    Numbers numbers = Numbers::ensure(read);
    if (numbers) return numbers;
    PyErr_Clear();
  } catch (const py::error_already_set&) {  // of a type that is no number
  }
  return {};
}

Numbers rows_of(py::handle given, std::string_view name, py::ssize_t columns) {
  const auto numbers = numbers_of(given);
  if (!numbers || numbers->ndim() != (columns == 1 ? 1 : 2) || (columns != 1 && numbers->shape(1) != columns)) {
    throw py::type_error(detail::in_quotes(name) + " takes an array of numbers of shape " + (columns == 1 ? "(n,)" : "(n, 3)"));
  }
  return *numbers;
}

double time_step_of(py::handle given) {
  const double step_s = number_of(given, "dt_s");
  if (step_s > 0.0 && step_s <= 1.0) return step_s;
  throw py::value_error("'dt_s' is " + detail::toml_number(step_s) +
                        "; a time step is in seconds, above 0 and at most 1: 1e-3 is a millisecond");
}

Vec3 vector_of(py::handle value, std::string_view name) {
  double numbers[3];
  const auto refuse = [&] {
    throw py::type_error(detail::in_quotes(name) + " takes three numbers [x, y, z], not " +
                         detail::one_line(py::str(value).cast<std::string>().substr(0, 60)));
  };
  PyObject* const object = value.ptr();
  if (PyTuple_Check(object) || PyList_Check(object)) {
    if (PySequence_Fast_GET_SIZE(object) != 3) refuse();
    for (int i = 0; i < 3; ++i) {
      const auto number = maybe_number(PySequence_Fast_GET_ITEM(object, i));
      if (!number) refuse();
      numbers[i] = *number;
    }
  } else if (py::isinstance<py::array>(value)) {
    const auto array = numbers_of(value);
    if (!array || array->ndim() != 1 || array->shape(0) != 3) refuse();
    for (int i = 0; i < 3; ++i) numbers[i] = array->at(i);
  } else {
    const auto several = maybe_numbers(value);
    if (!several || several->size() != 3) refuse();
    std::copy(several->begin(), several->end(), numbers);
  }
  return {numbers[0], numbers[1], numbers[2]};
}

py::array_t<double> array_of(const Vec3& v) {
  const double numbers[3] = {v.x, v.y, v.z};
  return py::array_t<double>(3, numbers);
}

Turn turn_of(py::handle value, std::string_view name) {
  const auto numbers = numbers_of(value);
  if (!numbers || numbers->ndim() != 1 || numbers->shape(0) != 4) {
    throw py::type_error(detail::in_quotes(name) + " takes four numbers [w, x, y, z], not " +
                         detail::one_line(py::str(value).cast<std::string>().substr(0, 60)));
  }
  return {numbers->at(0), numbers->at(1), numbers->at(2), numbers->at(3)};
}

py::array_t<double> array_of(const Turn& turn) {
  const double numbers[4] = {turn.w, turn.x, turn.y, turn.z};
  return py::array_t<double>(4, numbers);
}

py::list described(const detail::Keys& keys) {
  py::list all;
  for (const detail::Key& key : keys) {
    all.append(py::make_tuple(key.name, annotation_of(key), detail::form_of(key), key.fallback, key.sentence,
                              key.items.empty() ? py::object(py::none()) : described(key.items)));
  }
  return all;
}

void bind_parameters(py::module_& module) {
  module.def("numbers_of", [](const py::object& given) { return numbers_of(given); });
  module.def("time_step_of", [](const py::object& given) { return time_step_of(given); });
  py::class_<Part, PartPtr>(module, "Part")
      .def("get", [](const PartPtr& part, const std::string& name) { return value_of(part, name); })
      .def("set", [](Part& part, const std::string& name, const py::object& value) { set_value(part, name, value); })
      .def("type", [](Part& part) -> py::object {
        if (auto* mode = dynamic_cast<ModePart*>(&part)) return py::str(std::string(mode->mode().type()));
        if (auto* mode = dynamic_cast<SceneModePart*>(&part)) return py::str(std::string(mode->mode().mode.type()));
        return py::none();
      });
  bind_strengths(module);
  module.def("new_mode", [](const std::string& type) {
    const Mode* mode = known_modes().find(type);
    if (!mode) throw py::value_error("no mode type " + detail::in_quotes(type));
    return PartPtr(std::make_shared<ModePart>(*mode));
  });
  module.def("new_item", [](const PartPtr& part, const std::string& list) {
    ListFinder finder(list, [](ParameterList& items) { items.append(); });
    part->visit(finder);
    return PartPtr(std::make_shared<ItemPart>(part, list, 0));
  });
  module.def("mode_types", [] {
    py::list all;
    for (const Mode& mode : known_modes().modes()) {
      all.append(
          py::make_tuple(std::string(mode.type()), std::string(mode.summary()), described(detail::parameter_keys(mode))));
    }
    return all;
  });
  module.def("load_plugin", [](const std::filesystem::path& file) { load_plugin(file, known_modes()); });
  module.def("part_keys", [](const std::string& name) {
    if (name == "coupling") return described(detail::keys_of<CouplingOptions>());
    if (name == "workspace") return described(detail::keys_of<Workspace>());
    if (name == "time") return described(detail::keys_of<TimeOptions>());
    if (name == "tool") return described(detail::keys_of<ToolOptions>());
    return described(detail::keys_of<VolumeRequest>());
  });
}

}  // namespace palpa::python
