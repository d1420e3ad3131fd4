// Live scenes: felt in real time on a thread of their own, changed and watched from Python.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <unistd.h>

#include <memory>
#include <stdexcept>

#include "interruptible.h"
#include "palpa/device/paced_hand.h"
#include "palpa/study/live_run.h"
#include "parameters.h"
#include "run_options.h"
#include "study.h"

namespace palpa::python {
namespace {

void check_for_real_time(const Scene& scene) {
  if (const std::string why = what_is_not_for_real_time(scene); !why.empty()) throw SceneError(why);
}

/// A live run with its hand or device.
struct HeldRun {
  HeldRun(PreparedRun made, const RunOptions& options) : prepared(std::move(made)) {
    if (prepared.hand) paced.emplace(*prepared.hand);
    Device& device = paced ? static_cast<Device&>(*paced) : *prepared.real_device;
    run.emplace(options, prepared, device, TickObserver());
  }
  PreparedRun prepared;
  std::optional<PacedHand> paced;
  std::optional<LiveRun> run;
};

/// It for Python. A process that was forked has no thread of the loop: there it can be neither asked nor ended.
class Live {
 public:
  explicit Live(std::unique_ptr<HeldRun> held) : held_(std::move(held)) {}
  ~Live() {
    const py::gil_scoped_release release;
    if (is_forked()) static_cast<void>(held_.release());  // its thread could not be waited for
    held_.reset();
  }
  Live(const Live&) = delete;
  Live& operator=(const Live&) = delete;

  LiveRun& run() {
    if (is_forked()) throw std::runtime_error("the live scene is felt by the process that this one was forked from");
    return *held_->run;
  }

 private:
  bool is_forked() const { return ::getpid() != made_by_; }
  pid_t made_by_ = ::getpid();
  std::unique_ptr<HeldRun> held_;
};

std::unique_ptr<Live> start(const Scene& given, const py::dict& keywords) {
  RunOptions options = run_options(keywords);
  const Scene scene = given;
  check_for_real_time(scene);
  auto held = interruptible([&](const std::atomic<bool>&, std::stop_token token) {
    options.read.stop = std::move(token);
    options.live.emplace();
    return std::make_unique<HeldRun>(prepare(loaded_of(scene), options), options);
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
  seen["command_n"] = array_of(frame.command_n);
  seen["guard"] = name_of(frame.guard);
  seen["status"] = name_of(frame.result.status);
  return seen;
}

py::dict times_of(const LoopAccount::Times& times) {
  py::dict all;
  all["mean_us"] = times.mean_us;
  all["p50_us"] = times.p50_us;
  all["p99_us"] = times.p99_us;
  all["max_us"] = times.max_us;
  return all;
}

py::dict account_of(const LoopAccount& account) {
  py::dict all;
  all["ticks"] = account.ticks;
  all["missed"] = account.missed;
  all["unrecorded"] = account.unrecorded;
  all["scenes"] = account.scenes;
  all["late"] = times_of(account.late);
  all["tick"] = times_of(account.tick);
  return all;
}

}  // namespace

void bind_live(py::module_& module) {
  // Whatever takes a lock or waits does so without the interpreter's lock: what is freed there asks for it.
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
             run.scene().set(scene);
           })
      .def("look", [](Live& live) { return view_of(live.run().loop().look()); })
      .def("account", [](Live& live) { return account_of(live.run().loop().account()); })
      .def("has_ended", [](Live& live) { return live.run().has_ended(); })
      .def("panic", [](Live& live) { live.run().loop().panic(); })
      .def("resume", [](Live& live) { live.run().loop().resume(); })
      .def("finish", [](Live& live) {
        LiveRun& run = live.run();
        const py::gil_scoped_release release;
        return run.finish();
      });
  module.def("live", &start);
}

}  // namespace palpa::python
