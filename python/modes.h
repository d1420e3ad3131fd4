// Modes that are written in Python, and modes that are functions of C.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "palpa/scene/scene.h"

namespace palpa::python {

/// What a mode of Python's raised while this thread felt it. A tick cannot be left by an exception, so it is raised afterwards;
/// until then such modes place nothing.
class ModeFailure {
 public:
  /// While it lives, modes that this thread feels tell this failure.
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
  /// That of this thread; nullptr where nobody watches.
  static ModeFailure* watched() noexcept;

  ModeFailure() = default;
  ~ModeFailure();
  ModeFailure(const ModeFailure&) = delete;
  ModeFailure& operator=(const ModeFailure&) = delete;

  bool failed() const noexcept { return error_.has_value(); }
  /// Takes the exception under way in a `catch`. With the interpreter's lock.
  void keep(const pybind11::error_already_set& error) noexcept;
  /// Raises what was kept. With the interpreter's lock.
  void raise();

 private:
  std::optional<pybind11::error_already_set> error_;
  std::atomic<bool>* stop_ = nullptr;
};

/// The mode under the name that its scene has for it: a mode in Python says it where it raises.
Mode named(const Mode& mode, const std::string& name);
/// What modes have to say of what they did since they were asked last, a sentence each.
std::vector<std::string> told_by_modes(const Scene& scene);
/// The same as warnings of Python's (palpa.PalpaWarning), which may raise. With the interpreter's lock.
void warn_of_modes(const Scene& scene);
/// Whether a mode of the scene may ever have to.
bool may_tell(const Scene& scene);

/// Why a scene cannot be felt in real time; empty: it can.
std::string what_is_not_for_real_time(const Scene& scene);

void bind_modes(pybind11::module_& module);

}  // namespace palpa::python
