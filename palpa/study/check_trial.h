// A device, in a hand or let go, at one place of a scene: what its closed loop does.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpa/study/check_places.h"
#include "palpa/study/felt.h"

namespace palpa {

/// What a hand does at a place.
enum class Act : std::uint8_t {
  let_go,  ///< nobody holds the device, which falls by one to two millimetres on the place, pushed by its friction and 0.3 N
  lean,    ///< the same with 1.5 N, a finger that leans on it, and that finger's damping
  hold,    ///< in to the depth, and at rest there
  stroke,  ///< over the front at 5 cm/s
  press,   ///< in to the depth and out again, at up to 0.1 m/s, again and again
};
const char* name_of(Act act) noexcept;

/// [1] Of the friction that a device is said to have, the share by which it is to rest as well: two devices of one make may
/// differ by two. More: a device that is smoother than it is said to be hums; less: what laboratories feel every day is warned
/// of.
inline constexpr double sure_friction = 0.5;

/// What a hand does, and how it holds the device: relaxed or firm; of a device that is let go it does not matter.
struct Trial {
  Act act = Act::let_go;
  Hold hold = Hold::relaxed;
  double friction = 1.0;  ///< [1] share of its Coulomb friction that the device has
};
/// "held, firm".
std::string words_of(const Trial& trial);

/// What came of it.
struct TrialFigures {
  double rest_n = 0.0;        ///< root mean square of the force between 5 and 500 Hz, at rest; 0 where nothing is to be at rest
  double hum_m_per_s2 = 0.0;  ///< [m/s²] of it by the device's own mass: what skin feels
  double rough_n = 0.0;       ///< root mean square from 100 to 500 Hz, in contact, away from events, while it moves
  double most_n = 0.0;        ///< largest force on the hand
  double jump_n = 0.0;        ///< largest step of the force in a tick beyond the coupling's, whatever its cause
  double jump_s = 0.0;        ///< [s] when
  StepCause jump_cause = StepCause::unknown;
  int untold_jumps = 0;   ///< of more than `felt_step_n`, that no event tells
  std::string jump_mode;  ///< whose force changed most in the last of them; empty: none
  double duration_s = 0.0;
  double saturated = 0.0;            ///< [1] share of ticks in which the guard held some of the force back
  double overfull = 0.0;             ///< [1] share of ticks in which it did so and no unyielding level pushed most
  std::vector<double> pushed_n;      ///< by mode, the largest force in such ticks
  double over_budget = 0.0;          ///< [1] share of ticks whose work was spent before the proxy had come along
  double unborne_n = 0.0;            ///< largest force that no strength bore (Tick::unborne_n)
  std::vector<double> injected_j;    ///< by mode
  std::vector<double> dissipated_j;  ///< by mode
  double ticks_gained_j = 0.0;       ///< brought in by holding each force for a tick
};

/// Feels it on a simulated clock of 1 kHz. Allocates; any thread. Throws SceneError.
/// \param plant  with a mass above 0
TrialFigures try_at(const Scene& scene, const DevicePlant& plant, const CheckPlace& place, const Trial& trial);

}  // namespace palpa
