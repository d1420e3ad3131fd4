#include "own_device.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include "modes.h"
#include "palpa/base/wording.h"
#include "palpa/device/latest.h"
#include "palpa/loop/loop.h"
#include "parameters.h"

namespace palpa::python {
namespace {

using Clock = std::chrono::steady_clock;

// Longer: a hanging program pushes longer; shorter: a busy machine's pause drops the force.
constexpr std::chrono::milliseconds force_lifetime{20};
// Longer: older positions count; shorter: a busy interpreter's pause is a fault.
constexpr double state_lifetime_s = 0.05;
// Interval of exchanges. Shorter: more work; longer: forces come later.
constexpr std::chrono::milliseconds shortest_interval{1};
// Retry interval of code that raises. Longer: later recovery; shorter: more futile calls.
constexpr std::chrono::milliseconds retry_interval{100};
// Polling interval for hanging code. Longer: it is released later; shorter: more work.
constexpr std::chrono::milliseconds look_interval{10};
// At the end, for code that does not return. Longer: a program ends later; shorter: a slow device is not closed.
constexpr std::chrono::seconds longest_end{1};
constexpr double turn_tolerance = 1e-3;  // [1] of a quaternion's length, as of a session
constexpr std::size_t max_warnings = 8;  // [1] sentences; more: repetitions

double seconds(Clock::time_point time) { return std::chrono::duration<double>(time.time_since_epoch()).count(); }

/// Words of a fault with static lifetime, for a DeviceState.
const char* kept_words(const std::string& words) {
  constexpr std::size_t most_words = 64;  // [1] kept by the process; more: memory
  static std::mutex guards;
  static std::set<std::string>* const kept = new std::set<std::string>;
  const std::lock_guard lock(guards);
  if (const auto found = kept->find(words); found != kept->end()) return found->c_str();
  return kept->size() < most_words ? kept->insert(words).first->c_str() : "the device says that it has a fault";
}

/// State from the result of `read`: a DeviceState, three numbers, or None if the position is unknown.
DeviceState state_of(const py::object& returned) {
  DeviceState state;
  if (returned.is_none()) return state;
  if (py::isinstance<DeviceState>(returned)) {
    state = returned.cast<DeviceState>();
  } else {
    state.position_m = vector_of(returned, "read()");
    state.valid = true;
  }
  state.valid = state.valid && is_finite(state.position_m);
  if (!state.valid) state.buttons = 0;  // an absent handle holds no buttons
  if (state.velocity_m_per_s && !is_finite(*state.velocity_m_per_s)) state.velocity_m_per_s.reset();
  if (state.turn && !is_unit(*state.turn, turn_tolerance)) state.valid = false;
  return state;
}

DeviceLimits limits_of(const py::object& device) {
  const py::object limits = py::getattr(device, "limits", py::none());
  if (!py::isinstance<DeviceLimits>(limits)) {
    throw py::type_error(
        "a device says what its motors may be asked for: its class has limits = "
        "palpa.DeviceLimits(max_force_n=…)");
  }
  return limits.cast<DeviceLimits>();
}

std::string type_name(const py::object& object) { return object.get_type().attr("__name__").cast<std::string>(); }

}  // namespace

struct OwnDevice::Shared {
  struct Wish {
    Vec3 force_n, torque_nm{};
    Clock::time_point time{};
    bool is_zero() const noexcept { return force_n == Vec3{} && torque_nm == Vec3{}; }
  };
  py::object device;  // for its thread alone, with the interpreter's lock
  bool drives_torque = false;
  Latest<Wish> wishes;
  Latest<DeviceState> states;
  std::atomic<bool> ends{false}, is_linked{true}, rests{false};
  std::atomic<Clock::rep> since{0};  // start of the current exchange; 0: none
  mutable std::mutex guards;
  std::condition_variable over;
  bool is_over = false;
  std::vector<std::string> warnings;

  void tell(std::string sentence) {
    const std::lock_guard lock(guards);
    if (warnings.size() < max_warnings && std::ranges::find(warnings, sentence) == warnings.end())
      warnings.push_back(std::move(sentence));
  }
  /// Calls `write`. With the interpreter's lock; raises its exceptions.
  void write(const Wish& wish) {
    rests = false;
    drives_torque ? device.attr("write")(array_of(wish.force_n), array_of(wish.torque_nm))
                  : device.attr("write")(array_of(wish.force_n));
    rests = wish.is_zero();
  }
  bool exchange(const Wish& wish, bool may_push);
  void write_zero() noexcept;
  bool ended() const {
    const std::lock_guard lock(guards);
    return is_over;
  }

  /// Marks an exchange with Python code during its lifetime.
  struct Busy {
    explicit Busy(Shared& shared) : since(shared.since) { since = Clock::now().time_since_epoch().count(); }
    ~Busy() { since = 0; }
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;
    std::atomic<Clock::rep>& since;
  };
};

// One exchange; false if Python code raised.
bool OwnDevice::Shared::exchange(const Wish& wish, bool may_push) {
  const Busy busy(*this);
  const py::gil_scoped_acquire acquire;
  try {
    DeviceState state = state_of(device.attr("read")());
    const bool is_fresh = Clock::now() - wish.time < force_lifetime;
    write(may_push && is_fresh ? wish : Wish{});
    state.time_s = seconds(Clock::now());
    states.give(state);
    return true;
  } catch (py::error_already_set& error) {
    const std::string what = error.what();
    tell("the device's own code raised " + what.substr(0, what.find('\n')) +
         "; it was released, and no force was sent until it "
         "answered again");
  } catch (const std::exception& error) {
    tell(std::string("the device's own code raised ") + error.what());
  }
  states.give({.time_s = seconds(Clock::now()), .fault = "the device's own code raised an exception"});
  write_zero();
  return false;
}

// Writes zero force regardless of errors. With the interpreter's lock.
void OwnDevice::Shared::write_zero() noexcept {
  try {
    write({});
  } catch (const std::exception&) {  // already reported, or the reason for the release
  }
}

void OwnDevice::run(const std::shared_ptr<Shared>& shared) {
  bool is_well = true;
  while (!shared->ends) {
    const Clock::time_point begin = Clock::now();
    // After a failure the first exchange sends nothing: the loop must read the fault first.
    const Shared::Wish wish = shared->wishes.take();
    if (!wish.is_zero()) shared->rests = false;
    const bool went_well = shared->exchange(wish, is_well);
    shared->is_linked = went_well;
    is_well = went_well;
    const auto interval = went_well ? std::chrono::milliseconds(shortest_interval) : retry_interval;
    for (const auto until = begin + interval; !shared->ends && Clock::now() < until;)
      std::this_thread::sleep_until(std::min(until, Clock::now() + std::chrono::milliseconds(5)));
  }
  {
    const Shared::Busy busy(*shared);
    const py::gil_scoped_acquire acquire;
    shared->write_zero();
    try {
      if (py::hasattr(shared->device, "close")) shared->device.attr("close")();
    } catch (const std::exception& error) {
      shared->tell(std::string("the device could not be closed: ") + error.what());
    }
    shared->device = py::object();
  }
  const std::lock_guard lock(shared->guards);
  shared->is_over = true;
  shared->over.notify_all();
}

// Calls `release` of a device whose code does not return, once per hanging call.
void OwnDevice::watch(const std::shared_ptr<Shared>& shared) {
  constexpr auto longest = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(state_lifetime_s));
  for (Clock::rep released = 0; !shared->ended(); std::this_thread::sleep_for(look_interval)) {
    const Clock::rep since = shared->since;
    const bool hangs = since != 0 && Clock::now().time_since_epoch().count() - since > longest.count();
    if (!hangs || since == released || !Py_IsInitialized()) continue;
    const py::gil_scoped_acquire acquire;
    if (shared->since != since || !shared->device) continue;  // it returned
    released = since;
    try {
      shared->device.attr("release")();
    } catch (const std::exception& error) {
      const std::string what = error.what();
      shared->tell("the device's own 'release' raised " + what.substr(0, what.find('\n')));
    }
  }
}

OwnDevice::OwnDevice(py::object device) : limits_(limits_of(device)), shared_(std::make_shared<Shared>()) {
  name_ = type_name(device);
  shared_->device = std::move(device);
  shared_->drives_torque = limits_.max_torque_nm > 0.0;
  std::thread([shared = shared_] { run(shared); }).detach();
  std::thread([shared = shared_] { watch(shared); }).detach();
}

OwnDevice::~OwnDevice() { end(); }

void OwnDevice::end() {
  std::unique_lock lock(shared_->guards);
  if (shared_->ends.exchange(true)) return;
  if (shared_->over.wait_for(lock, longest_end, [&] { return shared_->is_over; })) return;
  lock.unlock();
  shared_->tell(
      "the device's own code did not return at the end; it is released as soon as it does, and until then may hold its "
      "last force");
}

DeviceState OwnDevice::read() noexcept {
  DeviceState state = shared_->states.take();
  if (state.valid && seconds(Clock::now()) - state.time_s > state_lifetime_s) {
    state.valid = false;
    state.buttons = 0;
    state.fault = "the device's own code does not return";
  }
  return state;
}

bool OwnDevice::write(const Vec3& force_n, const Vec3& torque_nm) noexcept {
  const bool is_usable = is_finite(force_n) && is_finite(torque_nm);
  shared_->wishes.give({is_usable ? shortened(force_n, limits_.max_force_n) : Vec3{},
                        is_usable ? shortened(torque_nm, limits_.max_torque_nm) : Vec3{}, Clock::now()});
  return shared_->is_linked.load(std::memory_order_relaxed);
}

bool OwnDevice::rests() const noexcept { return shared_->rests.load(std::memory_order_relaxed); }

std::vector<std::string> OwnDevice::warnings() const {
  const std::lock_guard lock(shared_->guards);
  return shared_->warnings;
}

namespace {

double in_range(double value, const char* name, bool may_be_zero) {
  if (value > 0.0 || (may_be_zero && value == 0.0)) return value;
  throw py::value_error(std::string("'") + name + "' is " + detail::toml_number(value) + "; it is a number " +
                        (may_be_zero ? "of at least 0" : "above 0"));
}

class Guarded {
 public:
  Guarded(const Scene& scene, const DeviceLimits& limits, std::uint32_t dead_man_buttons)
      : has_motors_(limits.has_motors),
        session_(clamped_to(scene, limits), limits.encoder_step_m),
        guarded_(session_, options(limits, scene, dead_man_buttons)) {}

  TickFrame tick(const py::object& position_m, double dt_s, const py::object& velocity_m_per_s, bool valid,
                 std::uint32_t buttons, bool fault, const py::object& turn) {
    if (in_use_.exchange(true)) throw std::runtime_error("another thread feels this session; each thread needs one of its own");
    const Leaves leaves{in_use_};
    Probe probe{.position_m = vector_of(position_m, "position_m"), .valid = valid, .buttons = buttons};
    if (!velocity_m_per_s.is_none()) probe.velocity_m_per_s = vector_of(velocity_m_per_s, "velocity_m_per_s");
    if (!turn.is_none()) probe.turn = turn_of(turn, "turn");
    std::uint32_t circumstances = 0;
    if (fault || std::exchange(has_failed_, false)) circumstances |= bit_of(Circumstance::device_fault);
    if (panics_) circumstances |= bit_of(Circumstance::panic);
    if (has_motors_ && dt_s > state_lifetime_s) circumstances |= bit_of(Circumstance::late);
    if (std::exchange(resumes_, false)) circumstances |= bit_of(Circumstance::resume);
    ModeFailure failure;
    const ModeFailure::Watch watch(failure);
    const TickFrame frame = guarded_.tick(ticks_++, t_s_, dt_s, probe, circumstances);
    if (dt_s > 0.0 && dt_s <= 1.0) t_s_ += dt_s;
    has_failed_ = failure.failed();
    failure.raise();
    return frame;
  }
  py::str text() const {
    py::list names;
    for (const SceneMode& mode : session_.scene().modes()) names.append(mode.name);
    return py::str("GuardedSession(modes={}, t_s={:.3f}{})").format(names, t_s_, panics_ ? ", panic" : "");
  }
  void panic() { panics_ = true; }
  void resume() { panics_ = false, resumes_ = true; }

 private:
  struct Leaves {
    std::atomic<bool>& in_use;
    ~Leaves() { in_use = false; }
  };
  static GuardOptions options(const DeviceLimits& limits, const Scene& scene, std::uint32_t dead_man_buttons) {
    GuardOptions options = guard_options_for(limits, scene.coupling().max_force_n);
    options.dead_man_buttons = dead_man_buttons;
    return options;
  }
  bool has_motors_ = true;
  Session session_;
  GuardedSession guarded_;
  std::int64_t ticks_ = 0;
  double t_s_ = 0.0;
  bool panics_ = false, resumes_ = false, has_failed_ = false;
  std::atomic<bool> in_use_{false};
};

void bind_limits(py::module_& module) {
  py::class_<DeviceLimits>(module, "DeviceLimits", "What a device may be asked for.")
      .def(py::init([](double max_force_n, bool has_motors, double max_stiffness_n_per_m, double workspace_radius_m,
                       double encoder_step_m, double continuous_force_n, double max_damping_ns_per_m, double damping_ns_per_m,
                       double max_torque_nm, double max_turn_stiffness_nm_per_rad, double max_turn_damping_nms_per_rad) {
             return DeviceLimits{
                 .max_force_n = in_range(max_force_n, "max_force_n", true),
                 .has_motors = has_motors,
                 .max_stiffness_n_per_m = in_range(max_stiffness_n_per_m, "max_stiffness_n_per_m", false),
                 .workspace_radius_m = in_range(workspace_radius_m, "workspace_radius_m", false),
                 .encoder_step_m = in_range(encoder_step_m, "encoder_step_m", true),
                 .continuous_force_n = in_range(continuous_force_n, "continuous_force_n", true),
                 .max_damping_ns_per_m = in_range(max_damping_ns_per_m, "max_damping_ns_per_m", true),
                 .damping_ns_per_m = in_range(damping_ns_per_m, "damping_ns_per_m", true),
                 .max_torque_nm = in_range(max_torque_nm, "max_torque_nm", true),
                 .max_turn_stiffness_nm_per_rad =
                     in_range(max_turn_stiffness_nm_per_rad, "max_turn_stiffness_nm_per_rad", false),
                 .max_turn_damping_nms_per_rad = in_range(max_turn_damping_nms_per_rad, "max_turn_damping_nms_per_rad", true)};
           }),
           py::kw_only(), py::arg("max_force_n"), py::arg("has_motors") = true, py::arg("max_stiffness_n_per_m") = 1e5,
           py::arg("workspace_radius_m") = 0.15, py::arg("encoder_step_m") = 0.0,
           py::arg("continuous_force_n") = std::numeric_limits<double>::infinity(),
           py::arg("max_damping_ns_per_m") = std::numeric_limits<double>::infinity(), py::arg("damping_ns_per_m") = 0.0,
           py::arg("max_torque_nm") = 0.0, py::arg("max_turn_stiffness_nm_per_rad") = std::numeric_limits<double>::infinity(),
           py::arg("max_turn_damping_nms_per_rad") = std::numeric_limits<double>::infinity())
      .def_readonly("max_force_n", &DeviceLimits::max_force_n, "[N] no force is larger")
      .def_readonly("has_motors", &DeviceLimits::has_motors, "False: nothing holds a force on the hand")
      .def_readonly("max_stiffness_n_per_m", &DeviceLimits::max_stiffness_n_per_m, "[N/m] the coupling is no stiffer")
      .def_readonly("workspace_radius_m", &DeviceLimits::workspace_radius_m, "[m]")
      .def_readonly("encoder_step_m", &DeviceLimits::encoder_step_m, "[m] 0: none")
      .def_readonly("continuous_force_n", &DeviceLimits::continuous_force_n, "[N] that its motors bear for ever")
      .def_readonly("max_damping_ns_per_m", &DeviceLimits::max_damping_ns_per_m, "[N*s/m] the coupling damps no more")
      .def_readonly("damping_ns_per_m", &DeviceLimits::damping_ns_per_m, "[N*s/m] of its own mechanics")
      .def_readonly("max_torque_nm", &DeviceLimits::max_torque_nm, "[N m] no torque is larger; 0: it drives none")
      .def_readonly("max_turn_stiffness_nm_per_rad", &DeviceLimits::max_turn_stiffness_nm_per_rad,
                    "[N m/rad] the coupling is no stiffer against turning")
      .def_readonly("max_turn_damping_nms_per_rad", &DeviceLimits::max_turn_damping_nms_per_rad,
                    "[N m s/rad] the coupling damps turning no more")
      .def("__repr__", [](const DeviceLimits& l) {
        return py::str("DeviceLimits(max_force_n={:g}, max_stiffness_n_per_m={:g}, encoder_step_m={:g})")
            .format(l.max_force_n, l.max_stiffness_n_per_m, l.encoder_step_m);
      });
}

void bind_state(py::module_& module) {
  py::class_<DeviceState>(module, "DeviceState", "A device at one moment, in the hand frame: what palpa.Device.read returns.")
      .def(py::init([](const py::object& position_m, const py::object& velocity_m_per_s, bool valid, std::uint32_t buttons,
                       const std::optional<std::string>& fault, const py::object& turn) {
             DeviceState state{.position_m = vector_of(position_m, "position_m"), .valid = valid, .buttons = buttons};
             if (!velocity_m_per_s.is_none()) state.velocity_m_per_s = vector_of(velocity_m_per_s, "velocity_m_per_s");
             if (fault) state.fault = kept_words(*fault);
             if (!turn.is_none()) state.turn = turn_of(turn, "turn");
             return state;
           }),
           py::arg("position_m"), py::kw_only(), py::arg("velocity_m_per_s") = py::none(), py::arg("valid") = true,
           py::arg("buttons") = 0, py::arg("fault") = py::none(), py::arg("turn") = py::none())
      .def_property_readonly(
          "position_m", [](const DeviceState& s) { return array_of(s.position_m); }, "[m] shape (3,)")
      .def_readonly("valid", &DeviceState::valid, "the position can be used")
      .def_readonly("buttons", &DeviceState::buttons, "those that are held, a bit each")
      .def_property_readonly(
          "turn", [](const DeviceState& s) { return s.turn ? py::object(array_of(*s.turn)) : py::object(py::none()); },
          "orientation of the handle, a unit quaternion (w, x, y, z); None: it senses none")
      .def_property_readonly(
          "fault", [](const DeviceState& s) { return s.fault ? py::object(py::str(s.fault)) : py::object(py::none()); },
          "why no force can be felt; None: all is well")
      .def("__repr__", [](const DeviceState& s) {
        return py::str("DeviceState({}, valid={}, buttons={})").format(array_of(s.position_m), s.valid, s.buttons);
      });
}

}  // namespace

void bind_devices(py::module_& module) {
  bind_limits(module);
  bind_state(module);
  py::class_<TickFrame>(module, "GuardedTick", "A tick and what the guard made of it.")
      .def_property_readonly(
          "command_n", [](const TickFrame& f) { return array_of(f.command.force_n); },
          "[N] shape (3,): the force that may be sent to the device, and nothing else")
      .def_property_readonly(
          "command_torque_nm", [](const TickFrame& f) { return array_of(f.command.torque_nm); },
          "[N m] shape (3,): likewise the torque; zero where the device drives none")
      .def_property_readonly(
          "guard", [](const TickFrame& f) { return name_of(f.command.guard); },
          "state of the guard (docs/safety.md): \"pass\", …")
      .def_property_readonly(
          "guard_cause", [](const TickFrame& f) { return name_of(f.command.cause); }, "why it is in that state; \"\": no cause")
      .def_property_readonly(
          "tick", [](const TickFrame& f) { return f.result; }, "the tick before the guard: a Tick")
      .def_readonly("t_s", &TickFrame::t_s, "[s] since the session began")
      .def("__repr__", [](const TickFrame& f) {
        return py::str("GuardedTick(command_n={}, guard={!r})").format(array_of(f.command.force_n), name_of(f.command.guard));
      });
  py::class_<Guarded>(
      module, "GuardedSession",
      "A scene being felt through the guard that stands before every motor (docs/safety.md), for a loop of one's\n"
      "own: limit, slew, gate and ramp, faults. palpa.live has a loop that keeps time, for a palpa.Device.\n\n"
      "limits: the device's; the scene's stiffness, damping and force are held to them.\n"
      "dead_man_buttons: one of these bits has to be held for a force; 0: none.")
      .def(py::init([](const Scene& scene, const DeviceLimits& limits, std::uint32_t dead_man_buttons) {
             return std::make_unique<Guarded>(scene, limits, dead_man_buttons);
           }),
           py::arg("scene"), py::arg("limits"), py::arg("dead_man_buttons") = 0)
      .def("tick", &Guarded::tick, py::arg("position_m"), py::arg("dt_s"), py::arg("velocity_m_per_s") = py::none(),
           py::arg("valid") = true, py::arg("buttons") = 0, py::arg("fault") = false, py::arg("turn") = py::none(),
           "One update; returns a GuardedTick, whose command_n is what may be sent.\n\n"
           "position_m, dt_s, velocity_m_per_s, valid, buttons, turn: as of Session.tick. fault: the device has one.\n"
           "A step above 0.05 s is late, for motors held the last force meanwhile: no force, then the gate and the ramp.\n"
           "Where a mode in Python raises, so does this, and the next tick counts as one after a fault: send zero then.")
      .def("__repr__", &Guarded::text)
      .def("panic", &Guarded::panic, "No force from the next tick on, until `resume`.")
      .def("resume", &Guarded::resume, "Lets it go on after a panic, with the gate and the ramp of a start.");
}

}  // namespace palpa::python
