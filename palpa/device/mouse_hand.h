// A mouse as a hand: what is felt is seen in how the cursor moves.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "palpa/device/device.h"
#include "palpa/device/latest.h"

namespace palpa {

/// A device without motors for a window with a pointer. The window moves it; the haptic thread reads it. What resists shows:
/// a motion against the rendered force is taken over slower, a third of it at the largest force (change of the ratio between
/// control and display: Lécuyer et al., IEEE VR 2000; a survey of it, 2009), and where the force is as large as it can be, not
/// at all, so that the hand cannot be drawn ever further into what holds the proxy. Motions along the force or across it are
/// whole. Draw the proxy, not the probe.
class MouseHand final : public Device {
 public:
  struct Options {
    double radius_m = 0.12;        ///< > 0: of the ball that the pointer stays in
    double largest_force_n = 3.3;  ///< > 0: at which it goes no further
    /// > 0: motions are spread over this time [s], since a mouse is told of 60 to 1000 times a second.
    double smoothing_s = 0.02;
    /// What `read` takes for the time.
    std::chrono::steady_clock::time_point (*now)() noexcept = &std::chrono::steady_clock::now;
  };
  MouseHand() noexcept : MouseHand(Options{}) {}
  explicit MouseHand(const Options& options) noexcept : options_(options) {}

  // ---- the window's thread ----

  /// Moves the hand by this, in the hand frame. What is not finite is left out. Allocates nothing.
  void move(const Vec3& way_m) noexcept;
  /// Puts the hand somewhere [m], in the hand frame, at once; what it was still to move is forgotten. Not for a hand that feels
  /// something: have the loop feel nothing meanwhile (`LiveLoop::move_view`). What is not finite is left out. Allocates
  /// nothing.
  void put(const Vec3& at_m) noexcept;
  /// Buttons that are held, a bit each.
  void press(std::uint32_t buttons) noexcept { buttons_.store(buttons, std::memory_order_relaxed); }
  /// Sets whether the window has the mouse; true at first. While false the hand rests where it is, no button is held, and
  /// `fault` is set, because another window receives motions and releases of buttons. When true again, the hand follows
  /// positions and buttons that are set from then on.
  void have_mouse(bool is_had) noexcept;

  // ---- the haptic thread ----

  std::string name() const override { return "pointer"; }
  DeviceLimits limits() const override {
    return {.max_force_n = options_.largest_force_n, .has_motors = false, .workspace_radius_m = options_.radius_m};
  }
  DeviceState read() noexcept override;
  bool write(const Vec3& force_n) noexcept override;
  bool rests() const noexcept override { return true; }

  /// Lets time pass in place of the clock on the wall, which `read` looks at: for a simulated clock. \param time_s  [s]
  void pass(double time_s) noexcept;

 private:
  const Options options_;
  // The window's: sums, since a taken value may have been several.
  struct Wanted {
    Vec3 moved_to_m;         // by all motions together
    Vec3 put_at_m;           // the last time that it was put …
    Vec3 put_from_m;         // … and how far all motions together had led then
    std::uint32_t puts = 0;  // so many times
  };
  Wanted told_;
  Latest<Wanted> wanted_;
  std::atomic<std::uint32_t> buttons_{0};
  std::atomic<bool> has_mouse_{true};
  // The haptic thread's.
  std::uint32_t puts_taken_ = 0;
  bool was_put_ = false;
  Vec3 taken_m_, pending_m_, position_m_, velocity_m_per_s_, force_n_;
  std::chrono::steady_clock::time_point passed_to_ = options_.now();
};

}  // namespace palpa
