#include "modes.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "palpa/base/wording.h"
#include "parameters.h"

namespace palpa::python {
namespace {

thread_local ModeFailure* watched_failure = nullptr;

/// Fields that a mode reads, by their names in the mode.
struct ReadFields {
  std::vector<std::pair<std::string, FieldRef>> fields;

  void visit(ParameterKind kind, ParameterVisitor& visitor) {
    for (auto& [name, ref] : fields) {
      visitor.field({.name = name, .sentence = "a field that the mode reads", .kind = kind, .needed = true}, ref);
    }
  }
};

/// Mode whose `place` is a method of a Python object.
struct PythonMode {
  static constexpr auto type = "python";
  static constexpr auto summary = "A mode that is written in Python.";

  ReadFields read;
  std::shared_ptr<const void> object;  // of Python
  bool strict = true;                  // raises on a primitive that would be refused
  std::string name = "python";         // in its scene

  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};
void visit_part(PythonMode& mode, ParameterVisitor& visitor) { mode.read.visit(ParameterKind::optional_field, visitor); }

/// Mode whose `place` is a C function.
struct CFunctionMode {
  static constexpr auto type = "c_function";
  static constexpr auto summary = "A mode that is a function of C.";

  /// \param in   proxy, probe and sample positions [m], 3 numbers each, time step [s], stiffness [N/m]; then of each scalar
  ///             field inside (1 or 0), value and gradient [unit/m]; of each vector field inside, 3 values and 9 of the
  ///             Jacobian
  /// \param out  rows of 9 for primitives: kind (0 point, 1 line, 2 plane, 3 directed force), position [m], direction [1],
  ///             strength [N], drag [N·s/m]; room for `most_primitives`
  /// Returns the number of rows.
  using Function = int (*)(const double* in, double* out);
  static constexpr std::size_t most_primitives = 16, most_fields = 8, numbers_of_one = 9;

  ReadFields scalars, vectors;
  Function function = nullptr;
  std::shared_ptr<const void> owner;  // keeps the function loaded
  /// Largest returned number of rows beyond the room, until reported; shared by all copies.
  std::shared_ptr<std::atomic<int>> excess = std::make_shared<std::atomic<int>>(0);

  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};
void visit_part(CFunctionMode& mode, ParameterVisitor& visitor) {
  mode.scalars.visit(ParameterKind::scalar_field, visitor);
  mode.vectors.visit(ParameterKind::vector_field, visitor);
}

/// Context of a Python mode, valid while its `place` runs.
class BoundContext {
 public:
  BoundContext(const ModeContext& context, const ReadFields& read) : context_(&context), read_(&read) {}
  void end() noexcept { context_ = nullptr; }
  const ModeContext& context() const {
    if (!context_) throw std::runtime_error("'here' and 'out' can be used only while 'place' runs");
    return *context_;
  }
  const FieldRef& field(const std::string& name) const {
    std::vector<std::string> names;
    for (const auto& [key, ref] : read_->fields) {
      if (ref.name == name) return ref;
      names.push_back(ref.name);
    }
    throw py::key_error("the mode reads no field " + detail::in_quotes(name) + "; " + detail::suggestion(name, names));
  }

 private:
  const ModeContext* context_;
  const ReadFields* read_;
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

void PythonMode::place(const ModeContext& context, PrimitiveSink sink) const noexcept {
  ModeFailure* const failure = ModeFailure::watched();
  if (failure && failure->failed()) return;
  const py::gil_scoped_acquire acquire;
  const auto tell = [&](const py::error_already_set& error) {
    if (failure) {
      failure->keep(error);
    } else {
      py::error_already_set(error).discard_as_unraisable("place");
    }
  };
  try {
    const auto here = std::make_shared<BoundContext>(context, read);
    const auto out = std::make_shared<BoundSink>(sink, context.proxy_m, *this);
    try {
      const py::handle mode(static_cast<PyObject*>(const_cast<void*>(object.get())));
      mode.attr("place")(here, out);
    } catch (const py::error_already_set& error) {
      tell(error);
    }
    here->end();
    out->end();
  } catch (const std::exception& error) {  // out of memory
    PyErr_SetString(PyExc_RuntimeError, error.what());
    tell(py::error_already_set());
  }
}

void CFunctionMode::place(const ModeContext& here, PrimitiveSink out) const noexcept {
  std::array<double, 11 + 13 * most_fields> in;
  double* next = put(put(put(in.data(), here.proxy_m), here.probe_m), here.at_m);
  *next++ = here.time_step_s;
  *next++ = here.stiffness_n_per_m;
  for (const auto& [name, ref] : scalars.fields) {
    const ScalarSample sample = here.scalar(ref);
    *next++ = sample.inside ? 1.0 : 0.0;
    *next++ = sample.value;
    next = put(next, sample.gradient);
  }
  for (const auto& [name, ref] : vectors.fields) {
    const VectorSample sample = here.vector(ref);
    *next++ = sample.inside ? 1.0 : 0.0;
    next = put(next, sample.value);
    for (const Vec3& row : sample.jacobian.row) next = put(next, row);
  }
  std::array<double, numbers_of_one * most_primitives> rows{};
  const int filled = function(in.data(), rows.data());
  const std::size_t count = std::min(static_cast<std::size_t>(std::max(filled, 0)), most_primitives);
  if (filled > static_cast<int>(most_primitives)) excess->store(filled, std::memory_order_relaxed);
  for (std::size_t n = 0; n < count; ++n) {
    const double* const row = rows.data() + numbers_of_one * n;
    const Vec3 position_m{row[1], row[2], row[3]}, direction{row[4], row[5], row[6]};
    const double strength_n = here.newtons(Strength(row[7])), drag_ns_per_m = here.drag(row[8]);
    const auto slot = static_cast<std::uint16_t>(n);
    if (row[0] == 0.0) {
      out.point(slot, position_m, strength_n, drag_ns_per_m);
    } else if (row[0] == 1.0) {
      out.line(slot, position_m, direction, strength_n, drag_ns_per_m);
    } else if (row[0] == 2.0) {
      out.plane(slot, position_m, direction, strength_n, {}, drag_ns_per_m);
    } else if (row[0] == 3.0) {
      out.directed(slot, direction, strength_n);
    }
  }
}

std::uint16_t slot_of(std::int64_t slot) {
  if (slot >= 0 && slot <= std::numeric_limits<std::uint16_t>::max()) return static_cast<std::uint16_t>(slot);
  throw py::value_error("'slot' is " + std::to_string(slot) + "; it lies between 0 and 65535");
}

// A field of the other kind would be outside everywhere: an error instead of silence.
ScalarSample scalar_of(const BoundContext& here, const std::string& name) {
  const ModeContext& context = here.context();
  const FieldRef& field = here.field(name);
  const ScalarSample sample = context.scalar(field);
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

ReadFields read_fields(const std::vector<std::pair<std::string, std::string>>& names) {
  ReadFields read;
  for (const auto& [key, name] : names) read.fields.emplace_back(key, FieldRef{name});
  return read;
}

void bind_samples(py::module_& module) {
  py::class_<ScalarSample>(module, "ScalarSample", "A sample of a scalar field.")
      .def_readonly("value", &ScalarSample::value, "in the field's own unit")
      .def_property_readonly(
          "gradient", [](const ScalarSample& s) { return array_of(s.gradient); }, "[unit/m], shape (3,)")
      .def_readonly("inside", &ScalarSample::inside, "the field has data here");
  py::class_<VectorSample>(module, "VectorSample", "A sample of a vector field.")
      .def_property_readonly(
          "value", [](const VectorSample& s) { return array_of(s.value); }, "in the field's own unit, shape (3,)")
      .def_property_readonly(
          "jacobian",
          [](const VectorSample& s) {
            py::array_t<double> jacobian({3, 3});
            double* to = jacobian.mutable_data();
            for (const Vec3& row : s.jacobian.row) to = put(to, row);
            return jacobian;
          },
          "[unit/m], shape (3, 3): row = component, column = axis of position")
      .def_readonly("inside", &VectorSample::inside, "the field has data here");
}

}  // namespace

ModeFailure::Watch::Watch(ModeFailure& failure, std::atomic<bool>* stop) noexcept : before_(watched_failure) {
  failure.stop_ = stop;
  watched_failure = &failure;
}
ModeFailure::Watch::~Watch() { watched_failure = before_; }
ModeFailure* ModeFailure::watched() noexcept { return watched_failure; }
ModeFailure::~ModeFailure() = default;

void ModeFailure::keep(const py::error_already_set& error) noexcept {
  if (!error_) error_.emplace(error);
  if (stop_) *stop_ = true;
}

void ModeFailure::raise() {
  if (!error_) return;
  const py::error_already_set error = *std::exchange(error_, std::nullopt);
  throw error;
}

std::string what_is_not_for_real_time(const Scene& scene) {
  for (const SceneMode& mode : scene.modes()) {
    if (mode.enabled && mode.mode.as<PythonMode>()) {
      return "mode " + detail::in_quotes(mode.name) +
             " is written in Python, which keeps no time: beside one busy thread a tick takes 5 ms; feel it with palpa.run, or "
             "give palpa.CFunction a function of C";
    }
  }
  return {};
}

Mode named(const Mode& mode, const std::string& name) {
  const auto* const in_python = mode.as<PythonMode>();
  if (!in_python) return mode;
  PythonMode copy = *in_python;
  copy.name = name;
  return Mode(std::move(copy));
}

std::vector<std::string> warnings_of_modes(const Scene& scene) {
  std::vector<std::string> sentences;
  for (const SceneMode& mode : scene.modes()) {
    const auto* const function = mode.mode.as<CFunctionMode>();
    const int returned = function ? function->excess->exchange(0, std::memory_order_relaxed) : 0;
    if (returned == 0) continue;
    sentences.push_back("mode " + detail::in_quotes(mode.name) + ": its function of C returned " + std::to_string(returned) +
                        " rows; there is room for " + std::to_string(CFunctionMode::most_primitives) +
                        ", and those beyond are not felt");
  }
  return sentences;
}

void warn_of_modes(const Scene& scene) {
  for (const std::string& sentence : warnings_of_modes(scene)) {
    const py::object category = py::module_::import("palpa").attr("PalpaWarning");
    if (PyErr_WarnEx(category.ptr(), sentence.c_str(), 1) != 0) throw py::error_already_set();
  }
}

bool may_tell(const Scene& scene) {
  return std::ranges::any_of(scene.modes(), [](const SceneMode& mode) { return mode.mode.as<CFunctionMode>() != nullptr; });
}

void bind_modes(py::module_& module) {
  bind_samples(module);
  py::class_<BoundContext, std::shared_ptr<BoundContext>>(module, "ModeContext",
                                                          "What a mode sees: the data at the proxy, in the hand frame.")
      .def_property_readonly(
          "proxy_m", [](const BoundContext& h) { return array_of(h.context().proxy_m); }, "[m] shape (3,)")
      .def_property_readonly(
          "probe_m", [](const BoundContext& h) { return array_of(h.context().probe_m); }, "[m] shape (3,)")
      .def_property_readonly(
          "at_m", [](const BoundContext& h) { return array_of(h.context().at_m); },
          "[m] shape (3,): where the data are sampled; usually the proxy")
      .def_property_readonly(
          "time_step_s", [](const BoundContext& h) { return h.context().time_step_s; }, "[s] of the sub-step")
      .def_property_readonly(
          "stiffness_n_per_m", [](const BoundContext& h) { return h.context().stiffness_n_per_m; }, "[N/m] of the coupling")
      .def_property_readonly(
          "finest_m", [](const BoundContext& h) { return h.context().finest_m; }, "[m] finest sample spacing")
      .def("scalar", &scalar_of, py::arg("field"),
           "The sample of a scalar field that the mode names; its gradient is per metre of the hand frame.")
      .def("vector", &vector_of_field, py::arg("field"),
           "The sample of a vector field that the mode names, turned into the hand frame.")
      .def(
          "newtons", [](const BoundContext& h, double strength_n) { return h.context().newtons(Strength(strength_n)); },
          py::arg("strength_n"), "The strength [N] times the mode's masks, faded towards the edges of its data.")
      .def(
          "drag", [](const BoundContext& h, double drag_ns_per_m) { return h.context().drag(drag_ns_per_m); },
          py::arg("drag_ns_per_m"), "The drag [N*s/m] times masks and fade.");
  py::class_<BoundSink, std::shared_ptr<BoundSink>>(module, "PrimitiveSink",
                                                    "Takes the primitives that a mode places. `slot` tells them apart.")
      .def(
          "point",
          [](const BoundSink& out, std::int64_t slot, const py::object& position_m, double strength_n, double drag) {
            const Vec3 at_m = vector_of(position_m, "position_m");
            out.place([&](PrimitiveSink sink) { sink.point(slot_of(slot), at_m, strength_n, drag); });
          },
          py::arg("slot"), py::arg("position_m"), py::arg("strength_n"), py::arg("drag_ns_per_m") = 0.0,
          "Holds the proxy at a position in every direction.")
      .def(
          "line",
          [](const BoundSink& out, std::int64_t slot, const py::object& position_m, const py::object& direction,
             double strength_n, double drag) {
            const Vec3 at_m = vector_of(position_m, "position_m"), along = vector_of(direction, "direction");
            out.place([&](PrimitiveSink sink) { sink.line(slot_of(slot), at_m, along, strength_n, drag); });
          },
          py::arg("slot"), py::arg("position_m"), py::arg("direction"), py::arg("strength_n"), py::arg("drag_ns_per_m") = 0.0,
          "Holds the proxy across the unit vector `direction`.")
      .def(
          "plane",
          [](const BoundSink& out, std::int64_t slot, const py::object& position_m, const py::object& normal, double strength_n,
             double drag) {
            const Vec3 at_m = vector_of(position_m, "position_m"), out_of_solid = vector_of(normal, "normal");
            out.place([&](PrimitiveSink sink) { sink.plane(slot_of(slot), at_m, out_of_solid, strength_n, {}, drag); });
          },
          py::arg("slot"), py::arg("position_m"), py::arg("normal"), py::arg("strength_n"), py::arg("drag_ns_per_m") = 0.0,
          "Pushes along the unit vector `normal` while the proxy is behind it.")
      .def(
          "directed",
          [](const BoundSink& out, std::int64_t slot, const py::object& direction, double strength_n) {
            const Vec3 along = vector_of(direction, "direction");
            out.place([&](PrimitiveSink sink) { sink.directed(slot_of(slot), along, strength_n); });
          },
          py::arg("slot"), py::arg("direction"), py::arg("strength_n"), "A force along the unit vector `direction`.");

  module.def("python_mode",
             [](const py::object& object, const std::vector<std::pair<std::string, std::string>>& fields, bool strict) {
               PythonMode mode{.read = read_fields(fields), .object = kept(object, object.ptr()), .strict = strict};
               return PartPtr(std::make_shared<ModePart>(Mode(std::move(mode))));
             });
  module.def("told_by_modes", &warnings_of_modes);
  module.def("c_function_mode", [](std::uintptr_t address, const std::vector<std::pair<std::string, std::string>>& scalars,
                                   const std::vector<std::pair<std::string, std::string>>& vectors, const py::object& owner) {
    if (address == 0) throw py::value_error("the function's address is 0; give that of a function of C");
    if (scalars.size() + vectors.size() > CFunctionMode::most_fields) {
      throw py::value_error("a function of C reads at most " + std::to_string(CFunctionMode::most_fields) + " fields");
    }
    CFunctionMode mode{.scalars = read_fields(scalars),
                       .vectors = read_fields(vectors),
                       .function = reinterpret_cast<CFunctionMode::Function>(address),
                       .owner = kept(owner, owner.ptr())};
    return PartPtr(std::make_shared<ModePart>(Mode(std::move(mode))));
  });
}

}  // namespace palpa::python
