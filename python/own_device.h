// Device written in Python, behind the guard: the live loop never calls Python.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <vector>

#include "palpa/device/device.h"

namespace palpa::python {

/// Device from a Python object with `limits`, `read()` and `write(force_n)`, or with limits of torque `write(force_n,
/// torque_nm)` (palpa.Device). A thread of its own alternates both calls, at most a thousand times a second; the loop only
/// exchanges a value, so the interpreter never blocks it. If Python code raises, or does not return for 50 ms, the device has a
/// fault: the guard removes the force, and only zero is written until a whole exchange has succeeded. While a call hangs,
/// another thread calls `release()`, by which the device may remove the force without that code. A force is not written later
/// than 20 ms after the loop set it.
class OwnDevice final : public Device {
 public:
  /// With the interpreter's lock. Raises TypeError if the object is no device.
  explicit OwnDevice(pybind11::object device);
  /// Ends it. Without the interpreter's lock.
  ~OwnDevice() override;

  std::string name() const override { return name_; }
  DeviceLimits limits() const override { return limits_; }
  DeviceState read() noexcept override;
  bool write(const Vec3& force_n) noexcept override { return write(force_n, {}); }
  bool write(const Vec3& force_n, const Vec3& torque_nm) noexcept override;
  bool rests() const noexcept override;

  /// Writes zero and closes the device on its thread; blocks for at most a second: code that does not return keeps its thread.
  /// Without the interpreter's lock; further calls do nothing.
  void end();
  /// Errors, a sentence each; any thread.
  std::vector<std::string> warnings() const;

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
