#include "session.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>

#include "arrays.h"
#include "modes.h"
#include "palpa/baseline/path.h"
#include "palpa/tick/session.h"
#include "palpa/trace/trace.h"
#include "parameters.h"

namespace palpa::python {
namespace {

/// One row of what `Session.ticks` returns: a Tick in numbers.
struct TickRow {
  double probe_m[3];
  double proxy_m[3];
  double proxy_velocity_m_per_s[3];
  double force_n[3];
  double error_bound_m;
  std::int32_t sub_steps;
  std::int32_t iterations;
  std::int32_t status;
  std::int32_t dropped;
};

TickRow row_of(const Tick& tick) {
  TickRow row;
  put(row.probe_m, tick.probe_m);
  put(row.proxy_m, tick.proxy_m);
  put(row.proxy_velocity_m_per_s, tick.proxy_velocity_m_per_s);
  put(row.force_n, tick.force_n);
  row.error_bound_m = tick.error_bound_m;
  row.sub_steps = tick.sub_steps;
  row.iterations = tick.iterations;
  row.status = static_cast<std::int32_t>(tick.status);
  row.dropped = tick.dropped;
  return row;
}

/// A session that one thread feels at a time.
class FeltSession {
 public:
  FeltSession(const Scene& scene, double encoder_step_m) : session_(scene, baseline::path, encoder_step_m) {}

  /// The session, for as long as it lives; RuntimeError where another thread has it.
  class Use {
   public:
    explicit Use(FeltSession& felt) : felt_(felt) {
      if (felt_.in_use_.exchange(true, std::memory_order_acquire))
        throw std::runtime_error("another thread feels this session; each thread needs one of its own");
    }
    ~Use() { felt_.in_use_.store(false, std::memory_order_release); }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    Session& session() { return felt_.session_; }

   private:
    FeltSession& felt_;
  };

 private:
  Session session_;
  std::atomic<bool> in_use_{false};
};

Tick tick(FeltSession& felt, const py::object& position_m, double dt_s, const py::object& velocity_m_per_s, bool valid,
          std::uint32_t buttons) {
  FeltSession::Use use(felt);
  Probe probe{.position_m = vector_of(position_m, "position_m"), .valid = valid, .buttons = buttons};
  if (!velocity_m_per_s.is_none()) probe.velocity_m_per_s = vector_of(velocity_m_per_s, "velocity_m_per_s");
  ModeFailure failure;
  const ModeFailure::Watch watch(failure);
  const Tick made = use.session().tick(probe, dt_s);
  failure.raise();
  return made;
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Rows of `columns` numbers.
Numbers rows_of(const py::object& given, const char* name, py::ssize_t columns) {
  Numbers numbers = Numbers::ensure(given);
  if (!numbers) PyErr_Clear();
  const bool fits = numbers && numbers.ndim() == (columns == 1 ? 1 : 2) && (columns == 1 || numbers.shape(1) == columns);
  if (!fits) {
    throw py::type_error(std::string("'") + name + "' takes an array of numbers of shape " +
                         (columns == 1 ? "(n,)" : "(n, 3)"));
  }
  return numbers;
}

py::array_t<TickRow> ticks(FeltSession& felt, const py::object& positions_m, const py::object& dt_s) {
  constexpr auto interval = std::chrono::milliseconds(50);  // Longer: Ctrl-C is heard later; shorter: more work
  constexpr py::ssize_t at_least = 64;                      // [1] ticks between two looks at the clock
  FeltSession::Use use(felt);
  const Numbers positions = rows_of(positions_m, "positions_m", 3);
  const py::ssize_t count = positions.shape(0);
  const bool one_step = PyNumber_Check(dt_s.ptr()) && !py::isinstance<py::array>(dt_s);
  const Numbers steps = one_step ? Numbers(1) : rows_of(dt_s, "dt_s", 1);
  if (!one_step && steps.shape(0) != count)
    throw py::value_error("'dt_s' has " + std::to_string(steps.shape(0)) + " time steps for " + std::to_string(count) +
                          " positions");
  const double step_s = one_step ? number_of(dt_s, "dt_s") : 0.0;

  py::array_t<TickRow> rows(count);
  const double* const from = positions.data();
  const double* const step = steps.data();
  TickRow* const to = rows.mutable_data();
  ModeFailure failure;
  {
    const py::gil_scoped_release release;
    const ModeFailure::Watch watch(failure);
    Session& session = use.session();
    auto look = std::chrono::steady_clock::now() + interval;
    for (py::ssize_t n = 0; n < count && !failure.failed(); ++n) {
      const double* const p = from + 3 * n;
      to[n] = row_of(session.tick({.position_m = {p[0], p[1], p[2]}}, one_step ? step_s : step[n]));
      if (n % at_least != at_least - 1 || std::chrono::steady_clock::now() < look) continue;
      const py::gil_scoped_acquire acquire;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      look = std::chrono::steady_clock::now() + interval;
    }
  }
  failure.raise();
  return rows;
}

py::dict modes_of(FeltSession& felt) {
  FeltSession::Use use(felt);
  const Session& session = use.session();
  const auto ticks = session.modes();
  py::dict modes;
  for (std::size_t m = 0; m < ticks.size(); ++m) modes[py::str(session.scene().modes()[m].name)] = ticks[m];
  return modes;
}

py::list events_of(FeltSession& felt) {
  FeltSession::Use use(felt);
  const Session& session = use.session();
  py::list events;
  for (const SessionEvent& event : session.events()) {
    const py::object subject = event.mode < 0 ? py::object(py::str("session"))
                                              : py::str(session.scene().modes()[static_cast<std::size_t>(event.mode)].name);
    const py::object value = event.text ? py::object(py::str(event.text)) : py::float_(event.value);
    events.append(py::make_tuple(name_of(event.kind), subject, value));
  }
  return events;
}

void bind_ticks(py::module_& module) {
  py::enum_<TickStatus>(module, "TickStatus", py::arithmetic(), "What became of a tick.")
      .value("resting", TickStatus::resting, "the proxy is where this probe position leads")
      .value("waiting", TickStatus::waiting, "the work of a tick is spent; the rest of the probe's path waits for the next one, and does not pull")
      .value("capped", TickStatus::capped, "resting, but a balance's bound is above 1e-9 m")
      .value("bad_input", TickStatus::bad_input, "the probe or the time step could not be used; the force is zero");
  py::class_<Energy>(module, "Energy", "The energy of one tick [J].")
      .def_readonly("stored_j", &Energy::stored_j, "in the spring after the tick")
      .def_readonly("elastic_j", &Energy::elastic_j, "in elastic levels after the tick")
      .def_readonly("dissipated_j", &Energy::dissipated_j, "taken out by modes")
      .def_readonly("injected_j", &Energy::injected_j, "brought in by modes")
      .def_readonly("path_j", &Energy::path_j, "error of walking the path in sub-steps")
      .def_readonly("damper_j", &Energy::damper_j, "work of the damper on the hand")
      .def_readonly("moved_j", &Energy::moved_j, "work of the data's own motion")
      .def_readonly("let_go_j", &Energy::let_go_j, "lost by the springs where a level let go")
      .def_readonly("ticks_j", &Energy::ticks_j, "brought in by holding the force for a tick");
  py::class_<Tick>(module, "Tick", "One tick's answer, in the hand frame. `force_n` is Eq. 1 before any limit.")
      .def_property_readonly(
          "probe_m", [](const Tick& t) { return array_of(t.probe_m); }, "[m] shape (3,)")
      .def_property_readonly(
          "probe_velocity_m_per_s", [](const Tick& t) { return array_of(t.probe_velocity_m_per_s); }, "[m/s] shape (3,)")
      .def_readonly("probe_valid", &Tick::probe_valid, "the device knew where it was")
      .def_property_readonly(
          "proxy_m", [](const Tick& t) { return array_of(t.proxy_m); }, "[m] shape (3,)")
      .def_property_readonly(
          "proxy_velocity_m_per_s", [](const Tick& t) { return array_of(t.proxy_velocity_m_per_s); }, "[m/s] shape (3,)")
      .def_property_readonly(
          "force_n", [](const Tick& t) { return array_of(t.force_n); }, "[N] shape (3,)")
      .def_readonly("error_bound_m", &Tick::error_bound_m, "[m] proven error of the balance, worst of the sub-steps")
      .def_readonly("sub_steps", &Tick::sub_steps, "balances along the proxy's path")
      .def_readonly("iterations", &Tick::iterations, "of the law, over all sub-steps")
      .def_readonly("status", &Tick::status, "what became of the tick")
      .def_readonly("dropped", &Tick::dropped, "primitives that were refused")
      .def_readonly("energy", &Tick::energy, "where energy came from and went [J]")
      .def("__repr__", [](const Tick& t) {
        return py::str("Tick(proxy_m={}, force_n={}, error_bound_m={:.3g}, status={!r})")
            .format(array_of(t.proxy_m), array_of(t.force_n), t.error_bound_m, name_of(t.status));
      });
  py::class_<ModeTick>(module, "ModeTick", "A mode's part in one tick.")
      .def_property_readonly(
          "force_n", [](const ModeTick& m) { return array_of(m.force_n); }, "[N] shape (3,), on the proxy")
      .def_readonly("dissipated_j", &ModeTick::dissipated_j, "[J]")
      .def_readonly("injected_j", &ModeTick::injected_j, "[J]")
      .def_readonly("primitives", &ModeTick::primitives, "in the last sub-step")
      .def_readonly("split_shared", &ModeTick::split_shared, "another split of the force would balance, too");
}

}  // namespace

void bind_session(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(TickRow, probe_m, proxy_m, proxy_velocity_m_per_s, force_n, error_bound_m, sub_steps, iterations, status,
                       dropped);
  bind_ticks(module);
  py::class_<FeltSession>(module, "Session",
                          "A scene being felt: the proxy, the modes' memories, the ledger.\n\n"
                          "It holds a snapshot of the scene (voxels shared). Each thread needs a session of its own.\n"
                          "encoder_step_m: [m] position step of the device, 0 if none.")
      .def(py::init([](const Scene& scene, double encoder_step_m) {
             const Scene copy = scene;
             const py::gil_scoped_release release;
             return std::make_unique<FeltSession>(copy, encoder_step_m);
           }),
           py::arg("scene"), py::arg("encoder_step_m") = 0.0)
      .def("tick", &tick, py::arg("position_m"), py::arg("dt_s"), py::arg("velocity_m_per_s") = py::none(),
           py::arg("valid") = true, py::arg("buttons") = 0,
           "One update: modes place primitives, the balance is solved, the proxy moves, the coupling pulls the hand.\n\n"
           "position_m: [m] where the hand is, hand frame. dt_s: [s] since the last tick, above 0 and at most 1.\n"
           "velocity_m_per_s: [m/s] of the hand; None: taken from the positions. valid: the device knows where it is.\n"
           "Returns a Tick; one that cannot be used has the status bad_input and no force.")
      .def("ticks", &ticks, py::arg("positions_m"), py::arg("dt_s"),
           "A tick for each row of positions_m, shape (n, 3), at the speed of C++: other threads go on meanwhile.\n\n"
           "dt_s: [s] one time step for all, or shape (n,).\n"
           "Returns a structured array with the fields probe_m, proxy_m, proxy_velocity_m_per_s, force_n (3 numbers each),\n"
           "error_bound_m, sub_steps, iterations, status (int(TickStatus)) and dropped.")
      .def(
          "reset", [](FeltSession& felt) { FeltSession::Use(felt).session().reset(); },
          "Puts the proxy on the next probe position and forgets all memories: after a gap.")
      .def("modes", &modes_of, "Who pushed in the last tick: a ModeTick for each mode, by name.")
      .def("events", &events_of, "What happened in the last tick: (kind, subject, value) each.")
      .def("_scene", [](FeltSession& felt) { return FeltSession::Use(felt).session().scene(); });
}

}  // namespace palpa::python
