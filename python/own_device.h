// A device of one's own in Python, behind the guard: the live loop never calls Python.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <vector>

#include "palpa/device/device.h"

namespace palpa::python {

/// An object of Python's with `limits`, `read()` and `write(force_n)` (palpa.Device) as a device. A thread of its own calls the
/// two, one exchange after the other, a thousand times a second at most; the loop only gives and takes a value, so that it
/// never waits for the interpreter. Where Python's code raises, or does not return for 50 ms, the device has a fault: the guard
/// then takes the force away, and nothing but zero is written until a whole exchange has gone well. Where it does not return
/// another thread calls `release()`, by which the device may let go without that code. A force that the loop did
/// not write anew for 20 ms is not written any more either.
class OwnDevice final : public Device {
 public:
  /// With the interpreter's lock. Raises TypeError where the object is no device.
  explicit OwnDevice(pybind11::object device);
  /// Ends it. Without the interpreter's lock.
  ~OwnDevice() override;

  std::string name() const override { return name_; }
  DeviceLimits limits() const override { return limits_; }
  DeviceState read() noexcept override;
  bool write(const Vec3& force_n) noexcept override;
  bool rests() const noexcept override;

  /// Has zero written and the device closed by its thread, and waits for that at most a second: code that does not return
  /// keeps its thread. Without the interpreter's lock; of later calls none does anything.
  void end();
  /// What went wrong, a sentence each; any thread.
  std::vector<std::string> told() const;

 private:
  struct Shared;
  static void run(const std::shared_ptr<Shared>& shared);
  static void watch(const std::shared_ptr<Shared>& shared);

  std::string name_;
  DeviceLimits limits_;
  std::shared_ptr<Shared> shared_;
};

void bind_devices(pybind11::module_& module);

}  // namespace palpa::python
