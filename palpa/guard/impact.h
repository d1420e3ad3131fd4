// Contact transient of hard levels.
#pragma once

#include <array>
#include <cstddef>

#include "palpa/guard/wrench.h"
namespace palpa {

/// Contact of a foot with a hard level.
struct HardContact {
  Vec3 normal;              ///< [1] of unit length, towards the foot
  double strength_n = 0.0;  ///< >= 0: that the level bears
  Vec3 lever_m{};           ///< from the device's point to the foot
};

/// A spring of any stiffness feels like foam: hardness is felt by the knock at contact. So at contact with a hard level a pulse
/// is added to the command, along the level's normal, open-loop: it grows with the speed of the impact and is then independent
/// of the hand (event-based feedback: Kuchenbecker, Fiene and Niemeyer, Improving contact realism through event-based haptic
/// feedback, IEEE TVCG 12(2), 2006). With v the speed along the normal and g the gain it is
///     g v (e^(−t/τ) − e^(−T/τ)) / (1 − e^(−T/τ)),  τ = 4 ms,  T = 20 ms, then zero,
/// and at most the level's strength. Hard levels are rigid, or elastic and stiffer than the coupling. A free hand of mass m
/// gains no energy while g is at most 2m over the pulse's 3.9 ms (docs/concepts.md).
///
/// Of a tool, speed and pulse are those of the foot at the level: the pulse acts on the hand with its torque about the device's
/// point.
///
/// The loop books its work on the hand with that of the guard. Allocates nothing; one thread.
class Impact {
 public:
  /// \param gain_ns_per_m  [N·s/m] >= 0; 0: no pulses, commands are unchanged
  explicit Impact(double gain_ns_per_m) noexcept : gain_ns_per_m_(gain_ns_per_m) {}

  /// Begins a tick.
  /// \param probe_step_m    [m] displacement of the probe since the last tick
  /// \param probe_turn_rad  [rad] likewise its rotation
  /// \param time_step_s     [s] > 0
  void move(const Vec3& probe_step_m, const Vec3& probe_turn_rad, double time_step_s) noexcept;
  /// A hard level was met in this tick. Only a higher pulse replaces one in progress.
  void hit(const HardContact& level) noexcept;
  /// Command of this tick with the pulse, before the guard.
  Wrench shape(const Wrench& command) const noexcept;
  /// Gain of the next pulse [N·s/m]; see the constructor.
  void set_gain(double gain_ns_per_m) noexcept { gain_ns_per_m_ = gain_ns_per_m; }
  /// Clears the pulse and the hand's velocity.
  void reset() noexcept { *this = Impact(gain_ns_per_m_); }

 private:
  struct Step {
    Vec3 way_m, turn_rad;
    double time_s = 0.0;
  };
  Vec3 velocity_m_per_s(const Vec3& lever_m) const noexcept;

  double gain_ns_per_m_;
  Wrench height_;                 // of the pulse, at its start
  double left_s_ = 0.0;           // of the pulse
  std::array<Step, 16> steps_{};  // last steps of the probe, in a ring
  std::size_t newest_ = 0;
};

}  // namespace palpa
