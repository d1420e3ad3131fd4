// Long work for Python: without the interpreter's lock, and ended by Ctrl-C.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <future>
#include <optional>
#include <stop_token>

#include "modes.h"

namespace palpa::python {

/// Runs `act(stop, token)` on a new thread without the interpreter's lock, while the calling thread checks signals. An
/// interrupt sets `stop` and `token`; KeyboardInterrupt is raised when `act` has returned. Throws the exceptions of `act` and
/// of Python modes in it.
template <class Act>
auto interruptible(const Act& act) {
  namespace py = pybind11;
  constexpr auto interval = std::chrono::milliseconds(50);  // Longer: Ctrl-C takes effect later; shorter: more work
  std::atomic<bool> stop{false};
  std::stop_source source;
  std::optional<py::error_already_set> interrupt;
  ModeFailure failure;
  std::future<decltype(act(stop, source.get_token()))> result;
  {
    const py::gil_scoped_release release;
    result = std::async(std::launch::async, [&] {
      const ModeFailure::Watch watch(failure, &stop);
      return act(stop, source.get_token());
    });
    while (result.wait_for(interval) != std::future_status::ready) {
      const py::gil_scoped_acquire acquire;
      if (interrupt || PyErr_CheckSignals() == 0) continue;
      interrupt.emplace();
      stop = true;
      source.request_stop();
    }
  }
  if (interrupt) throw *interrupt;
  failure.raise();
  return result.get();
}

}  // namespace palpa::python
