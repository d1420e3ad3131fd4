// Modes written in Python, and modes that are C functions.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "palpa/scene/scene.h"

namespace palpa::python {

/// Exception of a Python mode on this thread. It cannot leave a tick, so it is raised afterwards; until then these modes place
/// nothing.
class ModeFailure {
 public:
  /// During its lifetime, modes on this thread store their exceptions in this failure.
  class Watch {
   public:
    /// \param stop  set with the first failure; or nullptr
    explicit Watch(ModeFailure& failure, std::atomic<bool>* stop = nullptr) noexcept;
    ~Watch();
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

   private:
    ModeFailure* before_;
  };
  /// Failure of this thread; nullptr without a Watch.
  static ModeFailure* watched() noexcept;

  ModeFailure() = default;
  ~ModeFailure();
  ModeFailure(const ModeFailure&) = delete;
  ModeFailure& operator=(const ModeFailure&) = delete;

  bool failed() const noexcept { return error_.has_value(); }
  /// Stores the current exception of a `catch`. With the interpreter's lock.
  void keep(const pybind11::error_already_set& error) noexcept;
  /// Raises the stored exception. With the interpreter's lock.
  void raise();

 private:
  std::optional<pybind11::error_already_set> error_;
  std::atomic<bool>* stop_ = nullptr;
};

/// Messages of modes since the last call, a sentence each.
std::vector<std::string> warnings_of_modes(const Scene& scene);
/// Raises these messages as Python warnings (palpa.PalpaWarning), which may raise. With the interpreter's lock.
void warn_of_modes(const Scene& scene);
/// True if a mode of the scene may have messages.
bool may_tell(const Scene& scene);

/// Reason why a scene cannot run in real time; empty: it can.
std::string what_is_not_for_real_time(const Scene& scene);

void bind_modes(pybind11::module_& module);

}  // namespace palpa::python
