// Rate-controlled hand for input devices without a position: a SpaceMouse, a game controller, a mouse.
#pragma once

#include "palpa/device/device.h"
#include "palpa/solver/vec3.h"

namespace palpa {

/// Small mass, pushed by an input and by the rendered force:
///     m dv/dt = K·deflection − b v + force,   |x| ≤ radius
/// A deflection held in free space moves it at a steady speed (rate control: Zhai, Human Performance in Six Degree of Freedom
/// Input Control, 1995); a surface stops it, friction slows it, and the deflection is its pressure: without motors, forces
/// become visible (pseudo-haptics by an isometric input: Lécuyer et al., IEEE VR 2000). Backward Euler, at most 50 µs a step,
/// so it gains no energy. Allocates nothing; one thread.
class RateHand {
 public:
  struct Constants {
    double radius_m = 0.12;               ///< > 0: it stops at this distance from the centre
    double largest_speed_m_per_s = 0.15;  ///< > 0: in free space at full deflection
    double largest_push_n = 4.0;          ///< > 0: at full deflection
    double mass_kg = 0.1;                 ///< > 0
  };
  RateHand() noexcept : RateHand(Constants{}) {}
  explicit RateHand(const Constants& constants) noexcept : constants_(constants) {}

  /// Advances.
  /// \param deflection   [1] of full deflection, in the hand frame; longer ones count as 1, a non-finite one as 0
  /// \param force_n      [N] rendered; a non-finite one counts as 0
  /// \param time_step_s  [s] > 0; at most 0.1 is used
  void pass(const Vec3& deflection, const Vec3& force_n, double time_step_s) noexcept;
  const Vec3& position_m() const noexcept { return position_m_; }
  const Vec3& velocity_m_per_s() const noexcept { return velocity_m_per_s_; }

 private:
  Constants constants_;
  Vec3 position_m_;
  Vec3 velocity_m_per_s_;
};

/// Limits of a device that is a RateHand: no motors to protect, as the force only steers it. Allocates nothing; any thread.
inline DeviceLimits rate_hand_limits() noexcept {
  // [N] More: surfaces withstand harder pushes than the hand's; less: it pushes through.
  constexpr double most_n = 10.0;
  return {.max_force_n = most_n, .has_motors = false, .workspace_radius_m = RateHand::Constants{}.radius_m};
}

}  // namespace palpa
