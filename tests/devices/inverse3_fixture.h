// Fixture of an Inverse3 on a stand-in for the Inverse Service.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "palpa/base/load_error.h"
#include "palpa/device/open_device.h"
#include "tests/devices/inverse3_rig.h"

namespace palpa::test {

using Manner = Inverse3StandIn::Manner;
using Clock = std::chrono::steady_clock;

// Far above any run; only a failure takes it.
inline constexpr std::chrono::seconds patience{20};
inline constexpr double force_step_n = 1e-9;

inline std::string message_of(const std::function<void()>& refused) {
  try {
    refused();
  } catch (const LoadError& error) {
    return error.what();
  }
  return "nothing was refused";
}

class Inverse3 : public testing::Test {
 protected:
  DeviceSettings settings(DeviceSettings more = {}) const {
    more.emplace_back("port", std::to_string(service.port()));
    return more;
  }
  std::unique_ptr<Device> open(const DeviceSettings& more = {}) const {
    return device_backend("inverse3").open(settings(more));
  }

  /// Writes the force and reads the state each millisecond until the condition holds.
  template <class Condition>
  testing::AssertionResult comes(Device& device, const Vec3& force_n, Condition condition) {
    const auto end = Clock::now() + patience;
    while (Clock::now() < end) {
      is_linked = device.write(force_n);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      state = device.read();
      if (condition()) return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << "the last fault: " << (state.fault != nullptr ? state.fault : "none");
  }
  testing::AssertionResult is_felt(Device& device, const Vec3& force_n, const Vec3& made_n) {
    return comes(device, force_n, [&] { return state.valid && !state.fault && distance(felt_n(), made_n) < force_step_n; });
  }
  testing::AssertionResult is_felt(Device& device, const Vec3& force_n) { return is_felt(device, force_n, force_n); }
  testing::AssertionResult fails(Device& device, const Vec3& force_n) {
    return comes(device, force_n, [&] { return state.fault != nullptr && felt_n() == Vec3{}; });
  }
  Vec3 felt_n() { return hand_from_service(service.force_n()); }

  Inverse3StandIn service;
  DeviceState state;
  bool is_linked = false;
};

}  // namespace palpa::test
