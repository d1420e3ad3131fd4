// Mouse as a hand: pseudo-haptics by the cursor's motion.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "palpa/device/device.h"
#include "palpa/device/latest.h"

namespace palpa {

/// Device without motors for a window with a pointer. The window moves it; the haptic thread reads it. Resistance is visible: a
/// motion against the rendered force is slowed, down to a third near the largest force (change of the ratio between control and
/// display: Lécuyer et al., IEEE VR 2000; a survey of it, 2009), and stopped at it, so that the hand cannot be drawn ever
/// further into the object that holds the proxy. Motions along the force or across it are unchanged. Turns of its handle obey
/// the torque likewise. Draw the proxy, not the probe.
class MouseHand final : public Device {
 public:
  struct Options {
    double radius_m = 0.12;          ///< > 0: radius of the ball that confines the pointer
    double largest_force_n = 3.3;    ///< > 0: at this force, motion against it stops
    double largest_torque_nm = 0.3;  ///< > 0: at this torque, turning against it stops
    Turn turn{};                     ///< orientation at first, of unit length
    /// > 0: motions are smoothed over this time [s], since a mouse reports 60 to 1000 times a second. Before, each is spread
    /// over the interval between motions, up to 0.1 s: a slow window does not make the hand stop between them.
    double smoothing_s = 0.02;
    /// Clock of `read`.
    std::chrono::steady_clock::time_point (*now)() noexcept = &std::chrono::steady_clock::now;
  };
  MouseHand() noexcept : MouseHand(Options{}) {}
  explicit MouseHand(const Options& options) noexcept : options_(options) {}

  // ---- the window's thread ----

  /// Moves the hand by this, in the hand frame. Ignores non-finite values. Allocates nothing.
  void move(const Vec3& way_m) noexcept;
  /// Turns the handle further by this rotation vector, about axes of the hand frame. Ignores non-finite values. Allocates
  /// nothing.
  void turn(const Vec3& rotation_rad) noexcept;
  /// Sets the hand's position [m], in the hand frame, at once; discards pending motion. Not for a hand in contact: suspend the
  /// force meanwhile (`LiveLoop::hold_while_view_moves`). Ignores non-finite values. Allocates nothing.
  void put(const Vec3& at_m) noexcept;
  /// Sets the held buttons, a bit each.
  void press(std::uint32_t buttons) noexcept { buttons_.store(buttons, std::memory_order_relaxed); }
  /// Sets whether the window has the mouse; true at first. While false the hand rests at its position, no button is held, and
  /// `fault` is set, because another window receives motions and releases of buttons. When true again, the hand follows
  /// positions and buttons set from then on.
  void have_mouse(bool is_had) noexcept;

  // ---- the haptic thread ----

  std::string name() const override { return "pointer"; }
  DeviceLimits limits() const override {
    return {.max_force_n = options_.largest_force_n,
            .has_motors = false,
            .workspace_radius_m = options_.radius_m,
            .senses_turn = true,
            .max_torque_nm = options_.largest_torque_nm};
  }
  DeviceState read() noexcept override;
  bool write(const Vec3& force_n) noexcept override;
  bool write(const Vec3& force_n, const Vec3& torque_nm) noexcept override;
  bool rests() const noexcept override { return true; }

  /// Advances a simulated clock in place of the real one of `read`.
  /// \param time_s  [s]
  void pass(double time_s) noexcept;

 private:
  void move_on(double time_s) noexcept;
  void turn_on(double time_s) noexcept;

  const Options options_;
  // The window's: sums, since a taken value may combine several.
  struct Wanted {
    Vec3 moved_to_m;         // sum of all motions
    Vec3 put_at_m;           // last set position …
    Vec3 put_from_m;         // … and the sum of all motions then
    Turn turned_to;          // all turns
    std::uint32_t puts = 0;  // number of set positions
  };
  Wanted given_;
  Latest<Wanted> wanted_;
  std::atomic<std::uint32_t> buttons_{0};
  std::atomic<bool> has_mouse_{true};
  // The haptic thread's.
  std::uint32_t puts_taken_ = 0;
  bool was_put_ = false;
  Vec3 taken_m_, spread_m_, pending_m_, position_m_, velocity_m_per_s_, force_n_;
  Turn taken_turn_, turn_ = options_.turn, turns_to_ = options_.turn;
  Vec3 torque_nm_;
  double since_motion_s_ = 1.0, interval_s_ = 0.0, left_s_ = 0.0;  // of motions; what is left of the spread
  std::chrono::steady_clock::time_point passed_to_ = options_.now();
};

}  // namespace palpa
