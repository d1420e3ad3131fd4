// Device without a position: its deflection steers a RateHand.
#pragma once

#include <chrono>

#include "palpa/device/device.h"
#include "palpa/device/latest.h"
#include "palpa/device/rate_hand.h"

namespace palpa {

/// Reading of an input.
struct Deflection {
  Vec3 share;  ///< [1] of full deflection, in the hand frame
  std::uint32_t buttons = 0;
  const char* fault = nullptr;  ///< string literal
};

/// The haptic thread's side of an input whose own thread publishes deflections. During a fault the hand rests and all buttons
/// are up.
class RateHandDevice {
 public:
  Latest<Deflection> deflections;  ///< written by the input's thread

  DeviceState read() noexcept {
    const auto now = std::chrono::steady_clock::now();
    const Deflection& input = deflections.take();
    const double passed_s = std::chrono::duration<double>(now - passed_to_).count();
    hand_.pass(input.fault != nullptr ? Vec3{} : input.share, input.fault != nullptr ? Vec3{} : force_n_, passed_s);
    passed_to_ = now;
    return {.position_m = hand_.position_m(),
            .velocity_m_per_s = hand_.velocity_m_per_s(),
            .valid = true,
            .buttons = input.fault != nullptr ? 0u : input.buttons,
            .time_s = std::chrono::duration<double>(now.time_since_epoch()).count(),
            .fault = input.fault};
  }
  bool write(const Vec3& force_n) noexcept {
    force_n_ = is_finite(force_n) ? force_n : Vec3{};
    return true;
  }
  static DeviceLimits limits() noexcept { return rate_hand_limits(); }

 private:
  RateHand hand_;
  Vec3 force_n_;
  std::chrono::steady_clock::time_point passed_to_ = std::chrono::steady_clock::now();
};

}  // namespace palpa
