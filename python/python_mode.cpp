#include "python_mode.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <variant>

#include "arrays.h"
#include "modes.h"
#include "palpa/base/wording.h"
#include "parameters.h"

namespace palpa::python {
namespace {

using NamedNumbers = std::vector<std::pair<std::string, double>>;

/// Mode whose functions are methods of a Python object.
struct PythonMode {
  static constexpr auto type = "python";
  static constexpr auto summary = "A mode that is written in Python.";

  ReadFields read;
  std::vector<std::pair<std::string, Strength>> strengths;  // functions of fields
  NamedNumbers levels;                                      // of the field whose name is in the attribute `field`
  NamedNumbers remembered;                                  // names and first values of its memory
  std::shared_ptr<const void> object;                       // of Python
  bool strict = true;                                       // raises on a primitive that would be refused
  std::string name = "python";                              // in its scene

  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};
void visit_part(PythonMode& mode, ParameterVisitor& visitor) {
  mode.read.visit(ParameterKind::optional_field, visitor);
  for (auto& [name, value] : mode.levels)
    visitor.number({.name = name, .sentence = "a level that the mode stands on", .kind = ParameterKind::level}, value);
  for (auto& [name, strength] : mode.strengths)
    visitor.strength({.name = name, .sentence = "a strength of the mode", .kind = ParameterKind::strength}, strength);
}

/// Python mode with a memory.
struct RememberingMode : PythonMode {
  struct Memory {
    std::array<double, 31> numbers{};  // in the order of the names
    bool is_started = false;
  };
  void place(const ModeContext& here, const Memory& memory, PrimitiveSink out) const noexcept;
  void on_step_accepted(const StepResult& result, Memory& memory) const noexcept;
};

const PythonMode* python_mode_of(const Mode& mode) noexcept {
  if (const auto* plain = mode.as<PythonMode>()) return plain;
  return mode.as<RememberingMode>();
}

/// Context of a Python mode, valid while its method runs.
class BoundContext {
 public:
  BoundContext(const ModeContext& context, const PythonMode& mode) : context_(&context), mode_(&mode) {}
  void end() noexcept { context_ = nullptr; }
  bool is_over() const noexcept { return context_ == nullptr; }
  const ModeContext& context() const {
    if (!context_) throw std::runtime_error("'here' and 'out' can be used only while 'place' runs");
    return *context_;
  }
  const FieldRef& field(const std::string& name) const {
    std::vector<std::string> names;
    for (const auto& [key, ref] : mode_->read.fields) {
      if (ref.name == name) return ref;
      names.push_back(ref.name);
    }
    throw py::key_error("the mode reads no field " + detail::in_quotes(name) + "; " + detail::suggestion(name, names));
  }
  /// Name of a field by its number in the session; empty for fields of other modes.
  std::string name_of(std::int32_t number) const {
    for (const auto& [key, ref] : mode_->read.fields) {
      if (detail::field_numbers(ref).field == number) return ref.name;
    }
    return {};
  }
  /// The mode's own strength that is equal to this one: its field is known to the session.
  const Strength& strength(const Strength& given) const {
    for (const auto& [key, own] : mode_->strengths) {
      if (own == given) return own;
    }
    throw py::key_error(
        "the mode names no strength like this one; 'strengths' of its class lists the attributes that hold a "
        "palpa.Strength");
  }

 private:
  const ModeContext* context_;
  const PythonMode* mode_;
};

class BoundSink {
 public:
  BoundSink(PrimitiveSink sink, const Vec3& start_m, const PythonMode& mode) : sink_(sink), mode_(&mode) {
    judge().clear(start_m);
  }
  void end() noexcept { mode_ = nullptr; }

  /// Calls `add` for one primitive; for a strict mode raises ValueError if the tick would refuse it.
  template <class Add>
  void place(const Add& add) const {
    if (!mode_) throw std::runtime_error("'here' and 'out' can be used only while 'place' runs");
    if (mode_->strict) {
      add(PrimitiveSink(judge()));
      if (const auto refused = judge().refused(); !refused.empty()) {
        throw py::value_error("mode " + detail::in_quotes(mode_->name) + ": " + sentence_of(refused.front().reason) +
                              "; 'strict = False' in its class leaves such a primitive out, as a mode in C++ does");
      }
    }
    add(sink_);
  }

 private:
  /// Primitives that the running mode has placed, as the tick would take them.
  static PrimitiveSet& judge() {
    thread_local PrimitiveSet set;
    return set;
  }

  PrimitiveSink sink_;
  const PythonMode* mode_;
};

/// Ends the use of a sink.
class Ends {
 public:
  explicit Ends(BoundSink& sink) noexcept : sink_(sink) {}
  ~Ends() { sink_.end(); }
  Ends(const Ends&) = delete;
  Ends& operator=(const Ends&) = delete;

 private:
  BoundSink& sink_;
};

/// Result of an accepted sub-step, valid while `on_step_accepted` runs.
struct BoundStep {
  const StepResult* result;
  std::shared_ptr<BoundContext> here;

  const StepResult& get() const {
    here->context();  // raises after the call
    return *result;
  }
};

/// Calls `act(here)` with the interpreter's lock; keeps its exception for after the tick. Does nothing after a failure.
template <class Act>
void in_python(const PythonMode& mode, const ModeContext& context, const Act& act) noexcept {
  ModeFailure* const failure = ModeFailure::watched();
  if (failure && failure->failed()) return;
  const py::gil_scoped_acquire acquire;
  const auto tell = [&](const py::error_already_set& error) {
    if (failure) {
      failure->keep(error);
    } else {
      py::error_already_set(error).discard_as_unraisable("a mode's method");
    }
  };
  try {
    const auto here = std::make_shared<BoundContext>(context, mode);
    try {
      act(here, py::handle(static_cast<PyObject*>(const_cast<void*>(mode.object.get()))));
    } catch (const py::error_already_set& error) {
      tell(error);
    } catch (const py::builtin_exception& error) {
      error.set_error();
      tell(py::error_already_set());
    }
    here->end();
  } catch (const std::exception& error) {  // out of memory
    PyErr_SetString(PyExc_RuntimeError, error.what());
    tell(py::error_already_set());
  }
}

py::dict dict_of(const RememberingMode& mode, const RememberingMode::Memory& memory) {
  py::dict numbers;
  for (std::size_t n = 0; n < mode.remembered.size(); ++n)
    numbers[py::str(mode.remembered[n].first)] = memory.is_started ? memory.numbers[n] : mode.remembered[n].second;
  return numbers;
}

void keep(const RememberingMode& mode, const py::dict& numbers, RememberingMode::Memory& memory) {
  std::vector<std::string> names;
  for (const auto& [name, first] : mode.remembered) names.push_back(name);
  for (const auto& [key, value] : numbers) {
    const std::string name = py::str(key).cast<std::string>();
    const auto at = std::ranges::find(names, name);
    if (at == names.end()) {
      throw py::key_error("mode " + detail::in_quotes(mode.name) + ": no " + detail::in_quotes(name) + " in its memory; " +
                          detail::suggestion(name, names));
    }
    memory.numbers[static_cast<std::size_t>(at - names.begin())] = number_of(value, name);
  }
  memory.is_started = true;
}

void PythonMode::place(const ModeContext& context, PrimitiveSink sink) const noexcept {
  in_python(*this, context, [&](const std::shared_ptr<BoundContext>& here, py::handle mode) {
    const auto out = std::make_shared<BoundSink>(sink, context.proxy_m, *this);
    const Ends ends(*out);
    mode.attr("place")(here, out);
  });
}

void RememberingMode::place(const ModeContext& context, const Memory& memory, PrimitiveSink sink) const noexcept {
  in_python(*this, context, [&](const std::shared_ptr<BoundContext>& here, py::handle mode) {
    const auto out = std::make_shared<BoundSink>(sink, context.proxy_m, *this);
    const Ends ends(*out);
    mode.attr("place")(here, dict_of(*this, memory), out);
  });
}

void RememberingMode::on_step_accepted(const StepResult& result, Memory& memory) const noexcept {
  in_python(*this, result.here, [&](const std::shared_ptr<BoundContext>& here, py::handle mode) {
    const py::dict numbers = dict_of(*this, memory);
    mode.attr("on_step_accepted")(BoundStep{&result, here}, numbers);
    keep(*this, numbers, memory);
  });
}

std::uint16_t slot_of(std::int64_t slot) {
  if (slot >= 0 && slot <= std::numeric_limits<std::uint16_t>::max()) return static_cast<std::uint16_t>(slot);
  throw py::value_error("'slot' is " + std::to_string(slot) + "; it lies between 0 and 65535");
}

Vec3 sampled_at(const BoundContext& here, const py::object& at_m) {
  return at_m.is_none() ? here.context().at_m : vector_of(at_m, "at_m");
}

// A field of the other kind would be outside everywhere: an error instead of silence.
ScalarSample scalar_of(const BoundContext& here, const std::string& name, const py::object& at_m) {
  const ModeContext& context = here.context();
  const FieldRef& field = here.field(name);
  const ScalarSample sample = context.scalar(field, sampled_at(here, at_m));
  if (!sample.inside && context.vector(field).inside)
    throw py::type_error("'scalar': field " + detail::in_quotes(name) + " holds vectors; 'vector' samples it");
  return sample;
}
VectorSample vector_of_field(const BoundContext& here, const std::string& name) {
  const ModeContext& context = here.context();
  const FieldRef& field = here.field(name);
  const VectorSample sample = context.vector(field);
  if (!sample.inside && context.scalar(field).inside)
    throw py::type_error("'vector': field " + detail::in_quotes(name) + " holds scalars; 'scalar' samples it");
  return sample;
}

using NumberOrFunction = std::variant<double, Strength>;

double newtons_of(const BoundContext& here, const NumberOrFunction& given, HeldLevel* level, bool solid_is_high) {
  const ModeContext& context = here.context();
  const auto* const number = std::get_if<double>(&given);
  const Strength constant(number ? *number : 0.0);
  const Strength& strength = number ? constant : here.strength(std::get<Strength>(given));
  if (!level) return context.newtons(strength);
  const auto side = solid_is_high ? TransferFunction::Side::above : TransferFunction::Side::below;
  const LevelStrength bears = context.newtons(strength, *level, side);
  level->limited = bears.limited;
  return bears.newtons;
}

py::array_t<double> array_of_rows(const Mat3& matrix) {
  py::array_t<double> rows({3, 3});
  double* to = rows.mutable_data();
  for (const Vec3& row : matrix.row) to = put(to, row);
  return rows;
}

py::array_t<double> hessian_of(const BoundContext& here, const std::string& field) {
  return array_of_rows(here.context().hessian(here.field(field)));
}
std::pair<double, double> range_of(const BoundContext& here, const std::string& field) {
  const ValueRange& range = here.context().range(here.field(field));
  return {range.min, range.max};
}
double value_at_start(const BoundContext& here, const std::string& field) {
  return here.context().value_at_start(here.field(field));
}
py::array_t<double> footing_of(const BoundContext& here, std::int64_t slot) {
  return array_of(here.context().footing_m(slot_of(slot)));
}
HeldLevel level_of(const BoundContext& here, const std::string& field, double value, std::optional<double> pressed_to) {
  return {here.context().number_of(here.field(field)), value, pressed_to.value_or(value), false};
}
double drag_of(const BoundContext& here, double drag_ns_per_m) { return here.context().drag(drag_ns_per_m); }

void bind_samples(py::module_& module) {
  py::class_<HeldLevel>(module, "HeldLevel", "A level of a field on which a plane stands.")
      .def_readonly("value", &HeldLevel::value, "in the field's own unit")
      .def_readonly("pressed_to", &HeldLevel::pressed_to, "in the field's own unit: where its plane is after it yielded")
      .def_readonly("limited", &HeldLevel::limited, "data end nearby: its strength is reduced")
      .def("__repr__", [](const HeldLevel& level) {
        return py::str("HeldLevel(value={}, pressed_to={}, limited={})").format(level.value, level.pressed_to, level.limited);
      });
  py::class_<ScalarSample>(module, "ScalarSample", "A sample of a scalar field.")
      .def_readonly("value", &ScalarSample::value, "in the field's own unit")
      .def_property_readonly(
          "gradient", [](const ScalarSample& s) { return array_of(s.gradient); }, "[unit/m], shape (3,)")
      .def_readonly("inside", &ScalarSample::inside, "the field has data here")
      .def("__repr__", [](const ScalarSample& s) {
        return py::str("ScalarSample(value={}, gradient={}, inside={})").format(s.value, array_of(s.gradient), s.inside);
      });
  py::class_<VectorSample>(module, "VectorSample", "A sample of a vector field.")
      .def_property_readonly(
          "value", [](const VectorSample& s) { return array_of(s.value); }, "in the field's own unit, shape (3,)")
      .def_property_readonly(
          "jacobian", [](const VectorSample& s) { return array_of_rows(s.jacobian); },
          "[unit/m], shape (3, 3): row = component, column = axis of position")
      .def_readonly("inside", &VectorSample::inside, "the field has data here")
      .def("__repr__", [](const VectorSample& s) {
        return py::str("VectorSample(value={}, inside={})").format(array_of(s.value), s.inside);
      });
}

void bind_context(py::module_& module) {
  const auto vector = [](Vec3 ModeContext::*member) {
    return [member](const BoundContext& here) { return array_of(here.context().*member); };
  };
  const auto number = [](double ModeContext::*member) {
    return [member](const BoundContext& here) { return here.context().*member; };
  };
  py::class_<BoundContext, std::shared_ptr<BoundContext>>(module, "ModeContext",
                                                          "What a mode sees: the data at the proxy, in the hand frame.")
      .def_property_readonly("proxy_m", vector(&ModeContext::proxy_m), "[m] shape (3,): the proxy at the start of the sub-step")
      .def_property_readonly("probe_m", vector(&ModeContext::probe_m), "[m] shape (3,)")
      .def_property_readonly("at_m", vector(&ModeContext::at_m),
                             "[m] shape (3,): where the data are sampled; usually the proxy")
      .def_property_readonly("time_step_s", number(&ModeContext::time_step_s), "[s] of the sub-step")
      .def_property_readonly("stiffness_n_per_m", number(&ModeContext::stiffness_n_per_m), "[N/m] of the coupling")
      .def_property_readonly("finest_m", number(&ModeContext::finest_m), "[m] finest sample spacing")
      .def_property_readonly("most_n", number(&ModeContext::most_n), "[N] force limit of guard and device; inf without one")
      .def("__repr__",
           [](const BoundContext& here) {
             if (here.is_over()) return py::str("ModeContext(of a call that is over)");
             const py::str text("ModeContext(proxy_m={}, probe_m={}, time_step_s={:.3g})");
             const ModeContext& context = here.context();
             return py::str(text.format(array_of(context.proxy_m), array_of(context.probe_m), context.time_step_s));
           })
      .def("scalar", &scalar_of, py::arg("field"), py::arg("at_m") = py::none(),
           "The sample of a scalar field that the mode names, at at_m [m]; None: at here.at_m. Its gradient is per metre of "
           "the\n"
           "hand frame.")
      .def("vector", &vector_of_field, py::arg("field"),
           "The sample of a vector field that the mode names, turned into the hand frame.")
      .def("hessian", &hessian_of, py::arg("field"), "Second derivative of a scalar field at at_m [unit/m2], shape (3, 3).")
      .def("range", &range_of, py::arg("field"), "Smallest and largest value of a scalar field.")
      .def("value_at_start", &value_at_start, py::arg("field"),
           "Value of a scalar field where the sub-step starts: the level on which a material holds the proxy.")
      .def("footing_m", &footing_of, py::arg("slot"),
           "[m] shape (3,): where the level of the plane in this slot is sampled: its footing, or at_m.")
      .def("level", &level_of, py::arg("field"), py::arg("value"), py::arg("pressed_to") = py::none(),
           "The level of a field on which a plane stands, for `newtons` and PrimitiveSink.plane.")
      .def(
          "newtons", &newtons_of, py::arg("strength_n"), py::arg("level") = py::none(), py::arg("solid_is_high") = true,
          "The strength [N] times the mode's masks, faded towards the edges of its data. strength_n: a number, or a\n"
          "palpa.Strength of the mode (`strengths`). level: of the plane that has this strength; fades later, at its own edge.")
      .def("drag", &drag_of, py::arg("drag_ns_per_m"), "The drag [N*s/m] times masks and fade.");
}

HeldLevel level_or_none(const HeldLevel* level) { return level ? *level : HeldLevel{}; }

void place_point(const BoundSink& out, std::int64_t slot, const py::object& position_m, double strength_n, double drag) {
  const Vec3 at_m = vector_of(position_m, "position_m");
  out.place([&](PrimitiveSink sink) { sink.point(slot_of(slot), at_m, strength_n, drag); });
}
void place_line(const BoundSink& out, std::int64_t slot, const py::object& position_m, const py::object& direction,
                double strength_n, double drag) {
  const Vec3 at_m = vector_of(position_m, "position_m"), along = vector_of(direction, "direction");
  out.place([&](PrimitiveSink sink) { sink.line(slot_of(slot), at_m, along, strength_n, drag); });
}
void place_plane(const BoundSink& out, std::int64_t slot, const py::object& position_m, const py::object& normal,
                 double strength_n, double drag, const HeldLevel* level) {
  const Vec3 at_m = vector_of(position_m, "position_m"), out_of_solid = vector_of(normal, "normal");
  const HeldLevel on = level_or_none(level);
  out.place([&](PrimitiveSink sink) { sink.plane(slot_of(slot), at_m, out_of_solid, strength_n, on, drag); });
}
void place_elastic_plane(const BoundSink& out, std::int64_t slot, const py::object& position_m, const py::object& normal,
                         double strength_n, double stiffness_n_per_m, const HeldLevel* level) {
  const Vec3 at_m = vector_of(position_m, "position_m"), out_of_solid = vector_of(normal, "normal");
  const HeldLevel on = level_or_none(level);
  out.place(
      [&](PrimitiveSink sink) { sink.elastic_plane(slot_of(slot), at_m, out_of_solid, strength_n, stiffness_n_per_m, on); });
}
void place_friction(const BoundSink& out, std::int64_t slot, std::int64_t plane_slot, const py::object& position_m,
                    double coefficient, double drag) {
  const Vec3 at_m = vector_of(position_m, "position_m");
  out.place([&](PrimitiveSink sink) { sink.friction(slot_of(slot), slot_of(plane_slot), at_m, coefficient, drag); });
}
void place_directed(const BoundSink& out, std::int64_t slot, const py::object& direction, double strength_n) {
  const Vec3 along = vector_of(direction, "direction");
  out.place([&](PrimitiveSink sink) { sink.directed(slot_of(slot), along, strength_n); });
}

void bind_sink(py::module_& module) {
  const auto drag = py::arg("drag_ns_per_m") = 0.0;
  const auto level = py::arg("level") = py::none();
  py::class_<BoundSink, std::shared_ptr<BoundSink>>(module, "PrimitiveSink",
                                                    "Takes the primitives that a mode places. `slot` tells them apart.")
      .def("__repr__", [](const BoundSink&) { return "PrimitiveSink(point, line, plane, elastic_plane, friction, directed)"; })
      .def("point", &place_point, py::arg("slot"), py::arg("position_m"), py::arg("strength_n"), drag,
           "Holds the proxy at a position in every direction.")
      .def("line", &place_line, py::arg("slot"), py::arg("position_m"), py::arg("direction"), py::arg("strength_n"), drag,
           "Holds the proxy across the unit vector `direction`.")
      .def("plane", &place_plane, py::arg("slot"), py::arg("position_m"), py::arg("normal"), py::arg("strength_n"), drag, level,
           "Pushes along the unit vector `normal` while the proxy is behind it. level: here.level(...) on which it stands: no\n"
           "sub-step crosses it.")
      .def("elastic_plane", &place_elastic_plane, py::arg("slot"), py::arg("position_m"), py::arg("normal"),
           py::arg("strength_n"), py::arg("stiffness_n_per_m"), level,
           "A plane that is deflected by its force divided by stiffness_n_per_m, above 0.")
      .def("friction", &place_friction, py::arg("slot"), py::arg("plane_slot"), py::arg("position_m"), py::arg("coefficient"),
           drag,
           "Friction: a line along the normal of the plane in plane_slot, placed before, as strong as coefficient times that\n"
           "plane's force.")
      .def("directed", &place_directed, py::arg("slot"), py::arg("direction"), py::arg("strength_n"),
           "A force along the unit vector `direction`.");
}

py::list crossings_of(const BoundStep& step) {
  py::list all;
  for (const Crossing& crossing : step.get().crossings) {
    const std::string field = step.here->name_of(crossing.field);
    if (!field.empty()) all.append(py::make_tuple(field, crossing.value, crossing.up));
  }
  return all;
}

void bind_step(py::module_& module) {
  py::class_<BoundStep>(module, "StepResult", "What became of an accepted sub-step, for a mode with a memory.")
      .def_property_readonly(
          "here", [](const BoundStep& step) { return step.here; }, "palpa.ModeContext at the new proxy")
      .def_property_readonly("crossings", &crossings_of,
                             "levels and points of strengths that were crossed, in their order: (field, value, up) each")
      .def("__repr__",
           [](const BoundStep& step) {
             if (step.here->is_over()) return py::str("StepResult(of a call that is over)");
             return py::str("StepResult(crossings={}, contacts={})").format(crossings_of(step), step.get().contacts.size());
           })
      .def(
          "state",
          [](const BoundStep& step, std::int64_t slot) { return std::string(name_of(step.get().state(slot_of(slot)))); },
          py::arg("slot"), "\"stick\", \"slip\" or \"off\", of the primitive in this slot; \"off\" without one.")
      .def(
          "placed", [](const BoundStep& step, std::int64_t slot) { return step.get().placed(slot_of(slot)); }, py::arg("slot"),
          "Whether the mode had placed a primitive in this slot.")
      .def(
          "yields", [](const BoundStep& step, std::int64_t slot) { return step.get().yields(slot_of(slot)); }, py::arg("slot"),
          "Whether the plane of this slot yields: if it slips, its level moves to the proxy, without a break-through.")
      .def(
          "captured",
          [](const BoundStep& step, std::int64_t slot) {
            const HeldLevel level = step.get().captured(slot_of(slot));
            return level.any() ? std::optional<HeldLevel>(level) : std::nullopt;
          },
          py::arg("slot"), "palpa.HeldLevel of the plane in this slot; None without one.");
}

}  // namespace

bool is_in_python(const Mode& mode) noexcept { return python_mode_of(mode) != nullptr; }

Mode named(const Mode& mode, const std::string& name) {
  if (const auto* const plain = mode.as<PythonMode>()) {
    PythonMode copy = *plain;
    copy.name = name;
    return Mode(std::move(copy));
  }
  const auto* const remembering = mode.as<RememberingMode>();
  if (!remembering) return mode;
  RememberingMode copy = *remembering;
  copy.name = name;
  return Mode(std::move(copy));
}

py::object python_object_of(const Mode& mode) {
  const PythonMode* const in_python = python_mode_of(mode);
  if (!in_python) return py::none();
  return py::reinterpret_borrow<py::object>(static_cast<PyObject*>(const_cast<void*>(in_python->object.get())));
}

void bind_python_modes(py::module_& module) {
  bind_samples(module);
  bind_context(module);
  bind_sink(module);
  bind_step(module);
  module.def("python_mode", [](const py::object& object, const std::vector<std::pair<std::string, std::string>>& fields,
                               const std::vector<std::pair<std::string, Strength>>& strengths, const NamedNumbers& levels,
                               const NamedNumbers& memory, bool strict) {
    const PythonMode mode{.read = ReadFields(fields),
                          .strengths = strengths,
                          .levels = levels,
                          .remembered = memory,
                          .object = kept(object, object.ptr()),
                          .strict = strict};
    constexpr std::size_t room = std::tuple_size_v<decltype(RememberingMode::Memory::numbers)>;
    if (memory.size() > room) {
      throw py::value_error("the memory of a mode has room for " + std::to_string(room) + " numbers, not " +
                            std::to_string(memory.size()));
    }
    return PartPtr(std::make_shared<ModePart>(memory.empty() ? Mode(mode) : Mode(RememberingMode{mode})));
  });
}

}  // namespace palpa::python
