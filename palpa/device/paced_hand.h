// Simulated hand in real time.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <string>

#include "palpa/device/device.h"

namespace palpa {

/// Simulated hand on the real clock: each read advances it by the time since the last. Allocates nothing beyond the hand.
class PacedHand final : public Device {
 public:
  /// \param hand  must outlive this object
  explicit PacedHand(SimulatedDevice& hand) : hand_(hand), passed_to_(Clock::now()) {}
  std::string name() const override { return hand_.name(); }
  DeviceLimits limits() const override { return hand_.limits(); }
  DeviceState read() noexcept override {
    const Clock::time_point now = Clock::now();
    hand_.advance(std::min(longest_step_s, std::chrono::duration<double>(now - passed_to_).count()));
    passed_to_ = now;
    return hand_.read();
  }
  bool write(const Vec3& force_n) noexcept override { return write(force_n, {}); }
  bool write(const Vec3& force_n, const Vec3& torque_nm) noexcept override {
    rests_.store(force_n == Vec3{} && torque_nm == Vec3{}, std::memory_order_release);
    return hand_.write(force_n, torque_nm);
  }
  bool rests() const noexcept override { return rests_.load(std::memory_order_acquire); }

 private:
  using Clock = std::chrono::steady_clock;
  // After a machine's sleep. Longer: the hand takes many steps at once; shorter: it falls behind the clock.
  static constexpr double longest_step_s = 0.1;
  SimulatedDevice& hand_;
  Clock::time_point passed_to_;
  std::atomic<bool> rests_{true};
};

}  // namespace palpa
