// Live scenes: rendered in real time on a thread of their own, changed and observed from Python.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <utility>

#include "interruptible.h"
#include "modes.h"
#include "own_device.h"
#include "palpa/device/latest.h"
#include "palpa/device/mouse_hand.h"
#include "palpa/device/paced_hand.h"
#include "palpa/study/live_run.h"
#include "parameters.h"
#include "run_options.h"
#include "session.h"
#include "study.h"

namespace palpa::python {
namespace {

void check_for_real_time(const Scene& scene) {
  if (const std::string why = what_is_not_for_real_time(scene); !why.empty()) throw SceneError(why);
}

/// Primitives of a tick, for drawing. Plain data, which the loop can copy.
struct Seen {
  static constexpr std::size_t most = 24;  // more: they hide each other
  std::array<PlacedPrimitive, most> primitives{};
  std::size_t count = 0;
};

/// Mouse as the hand of one run at a time.
struct OwnPointer {
  explicit OwnPointer(const MouseHand::Options& options) : hand(options) {}
  MouseHand hand;
  std::atomic<bool> is_held{false};
};

/// Holds a mouse from construction to `stop_holding`.
class PointerHold {
 public:
  explicit PointerHold(std::shared_ptr<OwnPointer> own) : pointer_(std::move(own)) {
    if (pointer_ && pointer_->is_held.exchange(true))
      throw py::value_error(
          "'device' is a palpa.MouseHand that is the hand of another live scene; stop that, or make another one");
    holds_ = pointer_ != nullptr;
  }
  ~PointerHold() { stop_holding(); }
  PointerHold(const PointerHold&) = delete;
  PointerHold& operator=(const PointerHold&) = delete;

  /// The device; null if there is none.
  Device* device() const noexcept { return pointer_ ? &pointer_->hand : nullptr; }
  /// Frees the mouse for another run.
  void stop_holding() noexcept {
    if (std::exchange(holds_, false)) pointer_->is_held = false;
  }

 private:
  std::shared_ptr<OwnPointer> pointer_;
  bool holds_ = false;
};

/// Live run with its hand or device.
struct HeldRun {
  /// \param mouse  device of the hand, if it is a mouse of the program; stays with the run
  /// \param made_in_python  device of the hand, if it is written in Python
  HeldRun(PreparedRun made, const RunOptions& options, std::shared_ptr<OwnPointer> mouse,
          std::unique_ptr<OwnDevice> made_in_python)
      : prepared(std::move(made)), pointer(std::move(mouse)), own(std::move(made_in_python)) {
    if (prepared.hand) paced.emplace(*prepared.hand);
    Device& device = pointer.device() ? *pointer.device()
                     : own            ? static_cast<Device&>(*own)
                     : paced          ? static_cast<Device&>(*paced)
                                      : *prepared.real_device;
    run.emplace(options, prepared, device, [this](const TickFrame&, const Session& session) { see(session); });
  }
  void see(const Session& session) noexcept {
    constexpr unsigned one_in = 8;  // [ticks] screens show sixty pictures a second
    if (told++ % one_in != 0) return;
    Seen now;
    if (!session.sub_steps().empty()) {
      const SubStep& last = session.sub_steps().back();
      now.count = std::min<std::size_t>(static_cast<std::size_t>(last.primitives), Seen::most);
      std::copy_n(session.primitives().begin() + last.first_primitive, now.count, now.primitives.begin());
    }
    seen.give(now);
  }
  PreparedRun prepared;
  PointerHold pointer;
  std::unique_ptr<OwnDevice> own;
  std::optional<PacedHand> paced;
  unsigned told = 0;  // [ticks] counted by the loop
  Latest<Seen> seen;
  std::mutex looking;  // locked by readers of the latest primitives, never by the loop
  std::optional<LiveRun> run;
};

/// Live run for Python. A forked process lacks the loop's thread: it can neither read nor end the run.
class Live {
 public:
  explicit Live(std::unique_ptr<HeldRun> held) : held_(std::move(held)) {}
  ~Live() {
    const py::gil_scoped_release release;
    if (is_forked()) static_cast<void>(held_.release());  // its thread cannot be joined
    held_.reset();
  }
  Live(const Live&) = delete;
  Live& operator=(const Live&) = delete;

  /// Latest tick, of any thread.
  LiveView latest() {
    LiveRun& live = run();
    const std::lock_guard lock(held_->looking);
    return live.loop().latest();
  }
  /// Latest primitives, of any thread.
  Seen seen() {
    static_cast<void>(run());
    const std::lock_guard lock(held_->looking);
    return held_->seen.take();
  }

  LiveRun& run() {
    if (is_forked()) throw std::runtime_error("the live scene is felt by the process that this one was forked from");
    return *held_->run;
  }

  bool is_forked() const { return ::getpid() != made_by_; }

  std::string finish() {
    LiveRun& over = run();
    const std::string lost = over.finish();
    held_->pointer.stop_holding();
    if (held_->own) held_->own->end();
    return lost;
  }
  /// Messages, a sentence each.
  std::vector<std::string> told() {
    LiveRun& felt = run();
    std::vector<std::string> all = held_->prepared.loaded.warnings;
    all.insert(all.end(), held_->prepared.notes.begin(), held_->prepared.notes.end());
    for (std::string& sentence : warnings_of_modes(felt.scene().scene())) all.push_back(std::move(sentence));
    if (held_->own) {
      for (std::string& sentence : held_->own->warnings()) all.push_back(std::move(sentence));
    }
    return all;
  }

 private:
  pid_t made_by_ = ::getpid();
  std::unique_ptr<HeldRun> held_;
};

std::unique_ptr<Live> start(const Scene& given, const py::dict& keywords, const std::shared_ptr<OwnPointer>& pointer,
                            const py::object& own_device) {
  RunOptions options = run_options(keywords);
  const Scene scene = given;
  check_for_real_time(scene);
  if (pointer || !own_device.is_none()) {
    options.live.emplace();
    options.primitives = pointer != nullptr;
    PreparedRun prepared;
    prepared.loaded = loaded_of(scene);
    auto own = own_device.is_none() ? nullptr : std::make_unique<OwnDevice>(own_device);
    prepared.device = pointer ? pointer->hand.name() : own->name();
    prepared.duration_s = options.duration_s.value_or(std::numeric_limits<double>::infinity());
    const py::gil_scoped_release release;
    return std::make_unique<Live>(std::make_unique<HeldRun>(std::move(prepared), options, pointer, std::move(own)));
  }
  auto held = interruptible([&](const std::atomic<bool>&, std::stop_token token) {
    options.read.stop = std::move(token);
    options.live.emplace();
    return std::make_unique<HeldRun>(prepare(loaded_of(scene), options), options, nullptr, nullptr);
  });
  return std::make_unique<Live>(std::move(held));
}

py::dict view_of(const LiveView& view) {
  const TickFrame& frame = view.frame;
  py::dict seen;
  seen["tick"] = frame.tick;
  seen["t_s"] = frame.t_s;
  seen["probe_m"] = array_of(frame.result.probe_m);
  seen["proxy_m"] = array_of(frame.result.proxy_m);
  seen["force_n"] = array_of(frame.result.force_n);
  seen["command_n"] = array_of(frame.command.force_n);
  seen["guard"] = name_of(frame.command.guard);
  seen["status"] = name_of(frame.result.status);
  seen["guard_cause"] = name_of(frame.command.cause);
  seen["fault"] = view.device_fault ? py::object(py::str(view.device_fault)) : py::object(py::none());
  return seen;
}

py::dict times_of(const LoopStatistics::Times& times) {
  py::dict all;
  all["mean_us"] = times.mean_us;
  all["p50_us"] = times.p50_us;
  all["p99_us"] = times.p99_us;
  all["max_us"] = times.max_us;
  return all;
}

py::dict statistics_of(const LoopStatistics& statistics) {
  py::dict all;
  all["ticks"] = statistics.ticks;
  all["missed"] = statistics.missed;
  all["unrecorded"] = statistics.unrecorded;
  all["scenes"] = statistics.scenes;
  all["late"] = times_of(statistics.late);
  all["tick"] = times_of(statistics.tick);
  return all;
}

void bind_mouse_hand(py::module_& module) {
  py::class_<OwnPointer, std::shared_ptr<OwnPointer>>(
      module, "MouseHand",
      "A mouse as a hand, for palpa.live(scene, device=MouseHand()): a window moves it, the loop reads it. What resists "
      "shows:\n"
      "the more force there is against a motion, the less of it the hand takes over. Draw the proxy, not the probe.")
      .def(py::init([](double radius_m, double largest_force_n) {
             if (!(radius_m > 0.0) || !(largest_force_n > 0.0))
               throw py::value_error("'radius_m' and 'largest_force_n' lie above 0");
             return std::make_shared<OwnPointer>(MouseHand::Options{.radius_m = radius_m, .largest_force_n = largest_force_n});
           }),
           py::kw_only(), py::arg("radius_m") = 0.12, py::arg("largest_force_n") = 3.3)
      .def("__repr__", [](const OwnPointer&) { return "MouseHand(moved by move, put and press)"; })
      .def(
          "move", [](OwnPointer& pointer, const py::object& way_m) { pointer.hand.move(vector_of(way_m, "way_m")); },
          py::arg("way_m"), "Moves the hand by this [m], hand frame. One thread.")
      .def(
          "put", [](OwnPointer& pointer, const py::object& at_m) { pointer.hand.put(vector_of(at_m, "at_m")); },
          py::arg("at_m"), "Puts the hand there [m], hand frame, at once.")
      .def(
          "press", [](OwnPointer& pointer, std::uint32_t buttons) { pointer.hand.press(buttons); }, py::arg("buttons"),
          "The buttons that are held, a bit each.");
}

}  // namespace

void bind_live(py::module_& module) {
  // Code that locks or blocks runs without the interpreter's lock, because objects freed there need it.
  py::class_<Live>(module, "Live")
      .def("scene",
           [](Live& live) {
             LiveRun& run = live.run();
             const py::gil_scoped_release release;
             return run.scene().scene();
           })
      .def("set_scene",
           [](Live& live, const Scene& given) {
             const Scene scene = given;
             check_for_real_time(scene);
             LiveRun& run = live.run();
             const py::gil_scoped_release release;
             run.set_scene(scene);
           })
      .def("latest", [](Live& live) { return view_of(live.latest()); })
      .def("primitives",
           [](Live& live) {
             const Seen seen = live.seen();
             return primitives_of(std::span(seen.primitives).first(seen.count));
           })
      .def("statistics", [](Live& live) { return statistics_of(live.run().loop().statistics()); })
      .def("has_ended", [](Live& live) { return live.run().has_ended(); })
      .def("panic", [](Live& live) { live.run().loop().panic(); })
      .def("resume", [](Live& live) { live.run().loop().resume(); })
      .def("told",
           [](Live& live) {
             const py::gil_scoped_release release;
             return live.told();
           })
      .def("is_forked", &Live::is_forked)
      .def("finish", [](Live& live) {
        const py::gil_scoped_release release;
        return live.finish();
      });
  module.def("live", &start);
  module.def("with_motors_at_rest", [](const py::function& act) {
    const py::gil_scoped_release release;  // a Python device needs the interpreter to release
    const MotorsAtRest rest;
    const py::gil_scoped_acquire acquire;
    act();
  });
  bind_mouse_hand(module);
}

}  // namespace palpa::python
