// The knock of what is hard.
#pragma once

#include <array>
#include <cstddef>

#include "palpa/session/session.h"

namespace palpa {

/// A spring alone feels like foam however stiff it is: what says "hard" is the knock as one hits it. So where a hard level is
/// met a pulse is added to the command, along the level's normal, open-loop: it grows with the speed of the impact and then
/// does not ask what the hand does (event-based feedback: Kuchenbecker, Fiene and Niemeyer, Improving contact realism through
/// event-based haptic feedback, IEEE TVCG 12(2), 2006). With v the speed along the normal and g the gain it is
///     g v (e^(−t/τ) − e^(−T/τ)) / (1 − e^(−T/τ)),  τ = 4 ms,  T = 20 ms, then it is over,
/// and never higher than the level is strong. Hard is what is rigid, and an elastic level that is stiffer than the coupling.
/// A free hand of mass m is given no energy by it as long as g is at most 2m over the pulse's 3.9 ms (docs/concepts.md).
///
/// It does work on the hand like any other force: the loop books it with what the guard does to the force.
/// Allocates nothing; one thread.
class Impact {
 public:
  /// \param gain_ns_per_m  [N·s/m] >= 0; 0: there are no pulses, and nothing is done to a command
  explicit Impact(double gain_ns_per_m) noexcept : gain_ns_per_m_(gain_ns_per_m) {}

  /// What is to be sent in this tick. The guard comes after it.
  /// \param command_n     [N] what would be sent without
  /// \param session       just after the tick
  /// \param probe_step_m  [m] the way of the probe since the last tick
  /// \param time_step_s   [s] > 0
  Vec3 shape(const Vec3& command_n, const Session& session, const Vec3& probe_step_m, double time_step_s) noexcept;
  /// Of the next pulse [N·s/m]; see the constructor.
  void set_gain(double gain_ns_per_m) noexcept { gain_ns_per_m_ = gain_ns_per_m; }
  /// Forgets the pulse and how fast the hand was.
  void reset() noexcept { *this = Impact(gain_ns_per_m_); }

 private:
  struct Step {
    Vec3 way_m;
    double time_s = 0.0;
  };
  Vec3 velocity_m_per_s() const noexcept;
  void hit(const PlacedPrimitive& level) noexcept;

  double gain_ns_per_m_;
  Vec3 height_n_;                 // of the pulse, where it began
  double left_s_ = 0.0;           // of it
  std::array<Step, 16> steps_{};  // the last ones of the probe, in a ring
  std::size_t newest_ = 0;
};

}  // namespace palpa
