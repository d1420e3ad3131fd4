#include "session.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "arrays.h"
#include "modes.h"
#include "palpa/base/wording.h"
#include "palpa/loop/window_feed.h"
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
  double torque_nm[3];
  double probe_turn_rad[3];
  double proxy_turn_rad[3];
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
  put(row.torque_nm, tick.torque_nm);
  put(row.probe_turn_rad, rotation_rad(tick.probe_turn));
  put(row.proxy_turn_rad, rotation_rad(tick.proxy_turn));
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
    Tick tick(const Probe& probe, double dt_s) { return felt_.feed_.tick(probe, dt_s); }

   private:
    FeltSession& felt_;
  };

 private:
  Session session_;
  WindowFeed feed_{session_};
  const bool may_tell_;
  std::atomic<bool> in_use_{false};
};

Tick tick(FeltSession& felt, const py::object& position_m, double dt_s, const py::object& velocity_m_per_s, bool valid,
          std::uint32_t buttons, const py::object& turn) {
  FeltSession::Use use(felt);
  Probe probe{.position_m = vector_of(position_m, "position_m"), .valid = valid, .buttons = buttons};
  if (!velocity_m_per_s.is_none()) probe.velocity_m_per_s = vector_of(velocity_m_per_s, "velocity_m_per_s");
  if (!turn.is_none()) probe.turn = turn_of(turn, "turn");
  ModeFailure failure;
  const ModeFailure::Watch watch(failure);
  const Tick made = use.tick(probe, dt_s);
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

py::object subject_of(const Scene& scene, const SessionEvent& event) {
  if (event.mode < 0) return py::str("session");
  return py::str(scene.modes()[static_cast<std::size_t>(event.mode)].name);
}
py::object value_of(const SessionEvent& event) {
  return event.text ? py::object(py::str(event.text)) : py::float_(event.value);
}

/// Rotation vectors of this many ticks; none for None.
std::optional<Numbers> turns_of(const py::object& turns_rad, py::ssize_t count, const std::string& name) {
  if (turns_rad.is_none()) return {};
  Numbers turns = rows_of(turns_rad, name, 3);
  if (turns.shape(0) != count)
    throw py::value_error(detail::in_quotes(name) + " has " + std::to_string(turns.shape(0)) + " rotation vectors for " +
                          std::to_string(count) + " positions");
  return turns;
}

/// A path of the hand, and the ticks along it. Made and read with the interpreter's lock, run without it.
class TickPath {
 public:
  /// \param place  after the names of both, "" or "[2]"
  TickPath(const py::object& positions_m, const py::object& dt_s, const py::object& turns_rad, std::size_t modes,
           const std::string& name, const std::string& place)
      : positions_(rows_of(positions_m, name + place, 3)),
        count_(positions_.shape(0)),
        steps_(steps_of(dt_s, count_)),
        turns_(turns_of(turns_rad, count_, "turns_rad" + place)),
        rows_(count_),
        forces_({count_, static_cast<py::ssize_t>(modes), py::ssize_t{3}}),
        position_(positions_.data()),
        step_s_(steps_.data()),
        turn_rad_(turns_ ? turns_->data() : nullptr),
        row_(rows_.mutable_data()),
        force_(forces_.mutable_data()) {}

  /// Calls `goes_on(n)` after each tick; ends where it returns false.
  template <class GoesOn>
  void run(Session& session, const GoesOn& goes_on) {
    double t_s = 0.0;
    WindowFeed feed(session);
    for (py::ssize_t n = 0; n < count_; ++n) {
      const double* const p = position_ + 3 * n;
      Probe probe{.position_m = {p[0], p[1], p[2]}};
      if (const double* const r = turn_rad_ ? turn_rad_ + 3 * n : nullptr) probe.turn = turn_by({r[0], r[1], r[2]});
      row_[n] = row_of(feed.tick(probe, step_s_[n]), t_s);
      t_s += step_s_[n];
      for (const ModeForce& mode : session.modes()) force_ = put(force_, mode.force_n);
      for (const SessionEvent& event : session.events()) events_.push_back({n, event});
      if (!goes_on(n)) return;
    }
  }
  /// (rows, forces of the modes (n, modes, 3), names of the modes, events (tick, kind, subject, value) each).
  py::tuple results(const Scene& scene) const {
    py::list names, events;
    for (const SceneMode& mode : scene.modes()) names.append(mode.name);
    for (const auto& [n, event] : events_)
      events.append(py::make_tuple(n, name_of(event.kind), subject_of(scene, event), value_of(event)));
    return py::make_tuple(rows_, forces_, names, events);
  }

 private:
  Numbers positions_;
  py::ssize_t count_;
  Numbers steps_;
  std::optional<Numbers> turns_;
  py::array_t<TickRow> rows_;
  py::array_t<double> forces_;
  std::vector<ToldEvent> events_;
  const double* position_;
  const double* step_s_;
  const double* turn_rad_;  // null: none
  TickRow* row_;
  double* force_;
};

// Longer: Ctrl-C takes effect later; shorter: more work.
constexpr auto signal_interval = std::chrono::milliseconds(50);

/// With the interpreter's lock released: raises KeyboardInterrupt after Ctrl-C.
void check_signals() {
  const py::gil_scoped_acquire acquire;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

py::tuple ticks(FeltSession& felt, const py::object& positions_m, const py::object& dt_s, const py::object& turns_rad) {
  constexpr py::ssize_t at_least = 64;  // [1] ticks between checks of the clock
  FeltSession::Use use(felt);
  TickPath path(positions_m, dt_s, turns_rad, use.session().modes().size(), "positions_m", "");
  ModeFailure failure;
  {
    const py::gil_scoped_release release;
    const ModeFailure::Watch watch(failure);
    auto look = std::chrono::steady_clock::now() + signal_interval;
    path.run(use.session(), [&](py::ssize_t n) {
      if (failure.failed()) return false;
      if (n % at_least != at_least - 1 || std::chrono::steady_clock::now() < look) return true;
      check_signals();
      look = std::chrono::steady_clock::now() + signal_interval;
      return true;
    });
  }
  failure.raise();
  felt.tell();
  return path.results(use.session().scene());
}

/// Runs of one session for each path, on several threads.
class Rollout {
 public:
  struct Run {
    Scene scene;
    TickPath path;
    ModeFailure failure{};
    std::exception_ptr error{};
  };

  Rollout(std::deque<Run>& runs, Session* start) : runs_(runs), start_(start) {}

  /// Without the interpreter's lock.
  void run(int threads) {
    std::vector<std::jthread> workers;
    try {
      for (int n = 0; n < threads; ++n) workers.emplace_back([this] { work(); });
      std::unique_lock lock(mutex_);
      while (!ended_.wait_for(lock, signal_interval, [&] { return done_ == runs_.size(); })) {
        lock.unlock();
        check_signals();
        lock.lock();
      }
    } catch (...) {
      stops_ = true;
      throw;
    }
  }

 private:
  void work() noexcept {
    for (std::size_t n = next_++; n < runs_.size() && !stops_; n = next_++) {
      Run& run = runs_[n];
      try {
        const ModeFailure::Watch watch(run.failure);
        Session session(run.scene);
        if (start_) session.copy_state_from(*start_);
        run.path.run(session, [&](py::ssize_t) { return !stops_ && !run.failure.failed(); });
      } catch (...) {
        run.error = std::current_exception();
      }
      const std::lock_guard lock(mutex_);
      if (++done_ == runs_.size()) ended_.notify_one();
    }
  }

  std::deque<Run>& runs_;
  Session* const start_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> stops_{false};
  std::mutex mutex_;
  std::condition_variable ended_;
  std::size_t done_ = 0;
};

void check_equal_scenes(const Scene& scene, const Scene& of_start, const char* what) {
  if (to_toml(scene) != to_toml(of_start))
    throw py::value_error(std::string(what) +
                          ": the scenes differ; a state fits the scene that it was made in, and 'resume_in_changed_scene' "
                          "continues in another one");
}

/// \param turns_rad  for each path; empty: none
py::list rollout(const std::vector<std::shared_ptr<Scene>>& scenes, const py::list& paths_m, const py::object& dt_s,
                 const py::list& turns_rad, int threads, FeltSession* start) {
  std::optional<FeltSession::Use> use;
  if (start) use.emplace(*start);
  std::deque<Rollout::Run> runs;
  for (std::size_t n = 0; n < paths_m.size(); ++n) {
    const Scene& scene = *scenes[scenes.size() == 1 ? 0 : n];
    if (use) check_equal_scenes(scene, use->session().scene(), "rollout");
    const py::object turns = turns_rad.empty() ? py::none() : py::object(turns_rad[n]);
    runs.emplace_back(scene, TickPath(paths_m[n], dt_s, turns, scene.modes().size(), "paths_m", "[" + std::to_string(n) + "]"));
  }
  {
    const py::gil_scoped_release release;
    Rollout(runs, use ? &use->session() : nullptr).run(std::min(threads, static_cast<int>(runs.size())));
  }
  py::list results;
  for (Rollout::Run& run : runs) {
    if (run.error) std::rethrow_exception(run.error);
    run.failure.raise();
    warn_of_modes(run.scene);
    results.append(run.path.results(run.scene));
  }
  return results;
}

void copy_state(FeltSession& into, FeltSession& other) {
  if (&into == &other) return;
  FeltSession::Use use(into), use_other(other);
  check_equal_scenes(use.session().scene(), use_other.session().scene(), "Session.copy_state_from");
  use.session().copy_state_from(use_other.session());
}

void resume(FeltSession& into, FeltSession& other) {
  if (&into == &other) return;
  FeltSession::Use use(into), use_other(other);
  use.session().resume_in_changed_scene(use_other.session());
}

void refine_path(FeltSession& felt, int times) {
  constexpr int most = 16;
  if (times < 1 || times > most)
    throw py::value_error("Session.refine_path: 'times' is " + std::to_string(times) + "; it lies between 1 and 16");
  FeltSession::Use(felt).session().refine_path(times);
}

void set_force_limit(FeltSession& felt, double most_n) {
  if (!(most_n > 0.0))
    throw py::value_error("Session.set_force_limit: 'most_n' is " + detail::toml_number(most_n) +
                          "; it is a force in newtons above 0, inf without a limit");
  FeltSession::Use(felt).session().set_force_limit(most_n);
}

py::list sub_steps_of(FeltSession& felt) {
  FeltSession::Use use(felt);
  py::list all;
  for (const SubStep& step : use.session().sub_steps()) {
    py::dict one;
    one["time_step_s"] = step.time_step_s;
    one["start_m"] = array_of(step.start_m);
    one["probe_m"] = array_of(step.probe_m);
    one["stiffness_n_per_m"] = step.stiffness_n_per_m;
    one["balance_m"] = array_of(step.balance.position_m);
    one["proxy_m"] = array_of(step.proxy_m);
    one["directed_n"] = array_of(step.directed_n);
    one["start_turn"] = array_of(step.start_turn);
    one["probe_turn"] = array_of(step.probe_turn);
    one["turn_rad"] = array_of(step.balance.turn_rad);
    one["proxy_turn"] = array_of(step.proxy_turn);
    one["turning_radius_m"] = step.turning_radius_m;
    one["error_bound_m"] = step.balance.error_bound_m;
    one["stage"] = step.balance.stage;
    one["iterations"] = step.balance.iterations;
    one["stop"] = name_of(step.stop);
    one["primitives"] = py::make_tuple(step.first_primitive, step.first_primitive + step.primitives);
    all.append(one);
  }
  return all;
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
    events.append(py::make_tuple(name_of(event.kind), subject_of(session.scene(), event), value_of(event)));
  return events;
}

void bind_tick(py::module_& module) {
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
      .def_property_readonly(
          "torque_nm", [](const Tick& t) { return array_of(t.torque_nm); }, "[N m] shape (3,), of a tool, about the probe")
      .def_property_readonly(
          "probe_turn", [](const Tick& t) { return array_of(t.probe_turn); }, "orientation of a tool's handle, (w, x, y, z)")
      .def_property_readonly(
          "proxy_turn", [](const Tick& t) { return array_of(t.proxy_turn); }, "that of the tool in the data, (w, x, y, z)")
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
  bind_tick(module);
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

void bind_state(py::class_<FeltSession>& session) {
  session
      .def("copy_state_from", &copy_state, py::arg("other"),
           "Takes over the state of a session of an equal scene: proxy, memories, time, force limit. Both go on alike.\n\n"
           "Raises ValueError if the scenes differ.")
      .def("resume_in_changed_scene", &resume, py::arg("other"),
           "Continues from a session of another scene: with its whole state if both scenes' modes use equal levels of equal\n"
           "data, as after a change of strengths or coupling; else with its proxy and time, and fresh memories.")
      .def("refine_path", &refine_path, py::arg("times"), "Divides sub-steps by `times`, 1 to 16: for studies of convergence.")
      .def("set_force_limit", &set_force_limit, py::arg("most_n"),
           "Sets the force limit of guard and device [N], infinity by default: a stronger level cannot be broken through.")
      .def(
          "primitives", [](FeltSession& felt) { return primitives_of(FeltSession::Use(felt).session().primitives()); },
          "Primitives of the last tick, sub-step by sub-step: a dict each. kind; mode (its number in the scene), slot and "
          "foot;\n"
          "lever_m from the proxy to the foot of a tool;\n"
          "position_m, direction, strength_n, drag_ns_per_m, stiffness_n_per_m (inf: rigid); force_n on the proxy; state.")
      .def("sub_steps", &sub_steps_of,
           "Sub-steps of the last tick: a dict each. time_step_s; start_m, probe_m, balance_m, proxy_m; stiffness_n_per_m of "
           "the\n"
           "coupling; directed_n; of a tool start_turn, probe_turn, turn_rad from the start to the balance, proxy_turn and\n"
           "turning_radius_m (0: a point); error_bound_m, stage, iterations of the balance; stop, why the move ended; "
           "primitives "
           "(first, end) in primitives().")
      .def(
          "hand_to_world", [](FeltSession& felt) { return matrix_of(FeltSession::Use(felt).session().hand_to_world()); },
          "The map from the hand frame to the world [m], shape (4, 4).");
}

}  // namespace

py::list primitives_of(std::span<const PlacedPrimitive> placed) {
  py::list all;
  for (const PlacedPrimitive& each : placed) {
    const Primitive& primitive = each.primitive;
    py::dict one;
    one["kind"] = name_of(primitive.kind);
    one["mode"] = primitive.id.mode;
    one["slot"] = primitive.id.slot;
    one["foot"] = primitive.id.foot;
    one["lever_m"] = array_of(each.lever_m);
    one["position_m"] = array_of(primitive.position_m);
    one["direction"] = array_of(primitive.direction);
    one["strength_n"] = primitive.strength_n;
    one["drag_ns_per_m"] = primitive.drag_ns_per_m;
    one["stiffness_n_per_m"] = primitive.stiffness_n_per_m;
    one["force_n"] = array_of(each.force_n);
    one["state"] = name_of(each.state);
    all.append(one);
  }
  return all;
}

void bind_session(py::module_& module) {
  PYBIND11_NUMPY_DTYPE(TickRow, t_s, probe_m, proxy_m, proxy_velocity_m_per_s, force_n, torque_nm, probe_turn_rad,
                       proxy_turn_rad, error_bound_m, sub_steps, iterations, status, dropped, stored_j, elastic_j, dissipated_j,
                       injected_j, path_j, damper_j, moved_j, let_go_j, ticks_j);
  bind_ticks(module);
  py::class_<FeltSession> session(module, "Session",
                                  "A scene being felt: the proxy, the modes' memories, the ledger.\n\n"
                                  "It holds a snapshot of the scene (voxels shared). Each thread needs a session of its own.\n"
                                  "encoder_step_m: [m] position step of the device, 0 if none.");
  bind_state(session);
  session
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
           py::arg("valid") = true, py::arg("buttons") = 0, py::arg("turn") = py::none(),
           "One update: modes place primitives, the balance is solved, the proxy moves, the coupling pulls the hand.\n\n"
           "position_m: [m] where the hand is, hand frame. dt_s: [s] since the last tick, above 0 and at most 1.\n"
           "velocity_m_per_s: [m/s] of the hand; None: taken from the positions. valid: the device knows where it is.\n"
           "turn: orientation of a tool's handle, a unit quaternion (w, x, y, z); None: none.\n"
           "Returns a Tick; one that cannot be used has the status bad_input and no force.")
      .def("_ticks", &ticks, py::arg("positions_m"), py::arg("dt_s"), py::arg("turns_rad"))
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
  module.def("rollout", &rollout, py::arg("scenes"), py::arg("paths_m"), py::arg("dt_s"), py::arg("turns_rad"),
             py::arg("threads"), py::arg("start"));
}

}  // namespace palpa::python
