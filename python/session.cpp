#include "session.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <span>
#include <vector>

#include "arrays.h"
#include "modes.h"
#include "palpa/base/wording.h"
#include "palpa/session/session.h"
#include "palpa/trace/trace.h"
#include "parameters.h"

namespace palpa::python {
namespace {

/// Row of `Session.ticks`: a Tick in numbers.
struct TickRow {
  double t_s;
  double probe_m[3];
  double proxy_m[3];
  double proxy_velocity_m_per_s[3];
  double force_n[3];
  double error_bound_m;
  std::int32_t sub_steps;
  std::int32_t iterations;
  std::int32_t status;
  std::int32_t dropped;
  double stored_j, elastic_j, dissipated_j, injected_j, path_j, damper_j, moved_j, let_go_j, ticks_j;
};

TickRow row_of(const Tick& tick, double t_s) {
  const Energy& energy = tick.energy;
  TickRow row{.t_s = t_s,
              .stored_j = energy.stored_j,
              .elastic_j = energy.elastic_j,
              .dissipated_j = energy.dissipated_j,
              .injected_j = energy.injected_j,
              .path_j = energy.path_and_release_j,
              .damper_j = energy.damper_j,
              .moved_j = energy.data_motion_j,
              .let_go_j = energy.released_j,
              .ticks_j = energy.sampling_j};
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

/// Session for one thread at a time.
class FeltSession {
 public:
  FeltSession(const Scene& scene, double encoder_step_m)
      : session_(scene, encoder_step_m), may_tell_(python::may_tell(scene)) {}
  /// Raises the messages of its modes as warnings.
  void tell() {
    if (may_tell_) warn_of_modes(session_.scene());
  }

  /// Exclusive use of the session during its lifetime; RuntimeError if another thread uses it.
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
  const bool may_tell_;
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
  felt.tell();
  return made;
}

/// Time steps of this many ticks: one number for all, or a number for each.
Numbers steps_of(const py::object& dt_s, py::ssize_t count) {
  const bool is_one = PyNumber_Check(dt_s.ptr()) && (!py::isinstance<py::array>(dt_s) || dt_s.cast<py::array>().ndim() == 0);
  if (is_one) {
    Numbers steps(count);
    std::fill_n(steps.mutable_data(), count, time_step_of(dt_s));
    return steps;
  }
  Numbers steps = rows_of(dt_s, "dt_s", 1);
  if (steps.shape(0) != count)
    throw py::value_error("'dt_s' has " + std::to_string(steps.shape(0)) + " time steps for " + std::to_string(count) +
                          " positions");
  for (const double step_s : std::span(steps.data(), static_cast<std::size_t>(count))) {
    if (!(step_s > 0.0 && step_s <= 1.0)) time_step_of(py::float_(step_s));  // raises
  }
  return steps;
}

struct ToldEvent {
  py::ssize_t tick;
  SessionEvent event;
};

py::object subject_of(const Session& session, const SessionEvent& event) {
  if (event.mode < 0) return py::str("session");
  return py::str(session.scene().modes()[static_cast<std::size_t>(event.mode)].name);
}
py::object value_of(const SessionEvent& event) {
  return event.text ? py::object(py::str(event.text)) : py::float_(event.value);
}

/// (rows, forces of the modes (n, modes, 3), names of the modes, events (tick, kind, subject, value) each).
py::tuple ticks(FeltSession& felt, const py::object& positions_m, const py::object& dt_s) {
  constexpr auto interval = std::chrono::milliseconds(50);  // Longer: Ctrl-C takes effect later; shorter: more work
  constexpr py::ssize_t at_least = 64;                      // [1] ticks between checks of the clock
  FeltSession::Use use(felt);
  const Numbers positions = rows_of(positions_m, "positions_m", 3);
  const py::ssize_t count = positions.shape(0);
  const Numbers steps = steps_of(dt_s, count);
  Session& session = use.session();
  const std::size_t modes = session.modes().size();

  py::array_t<TickRow> rows(count);
  py::array_t<double> forces({count, static_cast<py::ssize_t>(modes), py::ssize_t{3}});
  const double* const from = positions.data();
  const double* const step = steps.data();
  TickRow* const to = rows.mutable_data();
  double* force = forces.mutable_data();
  std::vector<ToldEvent> events;
  double t_s = 0.0;
  ModeFailure failure;
  {
    const py::gil_scoped_release release;
    const ModeFailure::Watch watch(failure);
    auto look = std::chrono::steady_clock::now() + interval;
    for (py::ssize_t n = 0; n < count && !failure.failed(); ++n) {
      const double* const p = from + 3 * n;
      to[n] = row_of(session.tick({.position_m = {p[0], p[1], p[2]}}, step[n]), t_s);
      t_s += step[n];
      for (const ModeForce& mode : session.modes()) force = put(force, mode.force_n);
      for (const SessionEvent& event : session.events()) events.push_back({n, event});
      if (n % at_least != at_least - 1 || std::chrono::steady_clock::now() < look) continue;
      const py::gil_scoped_acquire acquire;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      look = std::chrono::steady_clock::now() + interval;
    }
  }
  failure.raise();
  felt.tell();
  py::list names, event_rows;
  for (std::size_t m = 0; m < modes; ++m) names.append(session.scene().modes()[m].name);
  for (const auto& [n, event] : events)
    event_rows.append(py::make_tuple(n, name_of(event.kind), subject_of(session, event), value_of(event)));
  return py::make_tuple(std::move(rows), std::move(forces), names, event_rows);
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
  for (const SessionEvent& event : session.events())
    events.append(py::make_tuple(name_of(event.kind), subject_of(session, event), value_of(event)));
  return events;
}

void bind_ticks(py::module_& module) {
  py::enum_<TickStatus>(module, "TickStatus", py::arithmetic(), "What became of a tick.")
      .value("resting", TickStatus::complete, "the proxy is where this probe position leads")
      .value("waiting", TickStatus::waiting,
             "the work of a tick is spent; the rest of the probe's path waits for the next one, and does not pull")
      .value("capped", TickStatus::capped, "resting, but a balance's bound is above 1e-9 m")
      .value("bad_input", TickStatus::bad_input, "the probe or the time step could not be used; the force is zero");
  py::class_<Energy>(module, "Energy", "The energy of one tick [J].")
      .def_readonly("stored_j", &Energy::stored_j, "in the spring after the tick")
      .def_readonly("elastic_j", &Energy::elastic_j, "in elastic levels after the tick")
      .def_readonly("dissipated_j", &Energy::dissipated_j, "taken out by modes")
      .def_readonly("injected_j", &Energy::injected_j, "brought in by modes")
      .def_readonly("path_j", &Energy::path_and_release_j, "error of walking the path in sub-steps")
      .def_readonly("damper_j", &Energy::damper_j, "work of the damper on the hand")
      .def_readonly("moved_j", &Energy::data_motion_j, "work of the data's own motion")
      .def_readonly("let_go_j", &Energy::released_j, "lost by the springs where a level let go")
      .def_readonly("ticks_j", &Energy::sampling_j, "brought in by holding the force for a tick")
      .def("__repr__", [](const Energy& e) {
        return py::str(
                   "Energy(stored_j={:.3g}, elastic_j={:.3g}, dissipated_j={:.3g}, injected_j={:.3g}, path_j={:.3g}, "
                   "damper_j={:.3g}, moved_j={:.3g}, let_go_j={:.3g}, ticks_j={:.3g})")
            .format(e.stored_j, e.elastic_j, e.dissipated_j, e.injected_j, e.path_and_release_j, e.damper_j, e.data_motion_j,
                    e.released_j, e.sampling_j);
      });
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
  py::class_<ModeForce>(module, "ModeForce", "A mode's part in one tick.")
      .def_property_readonly(
          "force_n", [](const ModeForce& m) { return array_of(m.force_n); }, "[N] shape (3,), on the proxy")
      .def_readonly("dissipated_j", &ModeForce::dissipated_j, "[J]")
      .def_readonly("injected_j", &ModeForce::injected_j, "[J]")
      .def_readonly("primitives", &ModeForce::primitives, "in the last sub-step")
      .def_readonly("split_shared", &ModeForce::split_shared, "another split of the force would balance, too")
      .def("__repr__", [](const ModeForce& m) {
        return py::str("ModeForce(force_n={}, dissipated_j={:.3g}, injected_j={:.3g}, primitives={})")
            .format(array_of(m.force_n), m.dissipated_j, m.injected_j, m.primitives);
      });
}

}  // namespace

void bind_session(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(TickRow, t_s, probe_m, proxy_m, proxy_velocity_m_per_s, force_n, error_bound_m, sub_steps, iterations,
                       status, dropped, stored_j, elastic_j, dissipated_j, injected_j, path_j, damper_j, moved_j, let_go_j,
                       ticks_j);
  bind_ticks(module);
  py::class_<FeltSession>(module, "Session",
                          "A scene being felt: the proxy, the modes' memories, the ledger.\n\n"
                          "It holds a snapshot of the scene (voxels shared). Each thread needs a session of its own.\n"
                          "encoder_step_m: [m] position step of the device, 0 if none.")
      .def(py::init([](const Scene& scene, double encoder_step_m) {
             if (!(encoder_step_m >= 0.0 && encoder_step_m < 1.0))
               throw py::value_error("Session: 'encoder_step_m' is " + detail::toml_number(encoder_step_m) +
                                     "; it is a length in metres, 0 where there is no encoder, below 1");
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
      .def("_ticks", &ticks, py::arg("positions_m"), py::arg("dt_s"))
      .def(
          "reset", [](FeltSession& felt) { FeltSession::Use(felt).session().reset(); },
          "Puts the proxy on the next probe position and forgets all memories: after a gap.")
      .def("_modes", &modes_of)
      .def("events", &events_of, "What happened in the last tick: (kind, subject, value) each.")
      .def("__repr__",
           [](FeltSession& felt) {
             FeltSession::Use use(felt);
             py::list names;
             for (const SceneMode& mode : use.session().scene().modes()) names.append(mode.name);
             return py::str("Session(modes={})").format(names);
           })
      .def("_scene", [](FeltSession& felt) { return FeltSession::Use(felt).session().scene(); });
}

}  // namespace palpa::python
