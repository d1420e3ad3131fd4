// A device of every kind (rig.h), written and read each millisecond.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>

#include "tests/devices/rig.h"

namespace palpa {
namespace conformance_test {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Far above any run; only a failure takes it.
inline constexpr std::chrono::seconds patience{20};
inline constexpr double force_step_n = 1e-9;

class EveryDevice : public testing::TestWithParam<NamedRig> {
 protected:
  std::unique_ptr<Rig> rig = GetParam().make();

  /// Writes the force and reads the state each millisecond until the condition holds.
  template <class Condition>
  testing::AssertionResult comes(Device& device, const Vec3& force_n, Condition condition) {
    for (const auto end = Clock::now() + patience; Clock::now() < end;) {
      is_linked = device.write(force_n);
      std::this_thread::sleep_for(milliseconds(1));
      state = device.read();
      if (condition()) return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << "the last fault: " << (state.fault != nullptr ? state.fault : "none");
  }
  testing::AssertionResult works(Device& device) {
    return comes(device, {}, [&] { return state.valid && state.fault == nullptr && is_linked; });
  }
  testing::AssertionResult makes(Device& device, const Vec3& force_n, const Vec3& made_n) {
    return comes(device, force_n, [&] { return distance(rig->force_n(), made_n) < force_step_n; });
  }

  DeviceState state;
  bool is_linked = false;
};

class DeviceWithMotors : public EveryDevice {};
class SteeredDevice : public EveryDevice {};

}  // namespace conformance_test
}  // namespace palpa
