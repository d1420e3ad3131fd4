// Closed-loop trial of a device, in a hand or released, at a place of a scene.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpa/study/check_places.h"
#include "palpa/study/felt.h"

namespace palpa {

/// Motion at a place.
enum class Act : std::uint8_t {
  released,  ///< the released device falls by one to two millimetres onto the place, pushed by its friction and 0.3 N
  lean,      ///< likewise with 1.5 N, a leaning finger, and that finger's damping
  hold,      ///< in to the depth, then at rest
  stroke,    ///< over the front at 5 cm/s
  press,     ///< in to the depth and out again, at up to 0.1 m/s, repeatedly
};
const char* name_of(Act act) noexcept;

/// [1] Share of the stated friction at which the device must rest, too: devices of a model may differ by a factor of two. More:
/// a device smoother than stated hums; less: warnings about everyday scenes.
inline constexpr double sure_friction = 0.5;

/// Motion, and hold of the device: relaxed or firm; ignored for a released device.
struct Trial {
  Act act = Act::released;
  Hold hold = Hold::relaxed;
  double friction = 1.0;  ///< [1] share of the device's Coulomb friction
};
/// "held, firm".
std::string format_trial(const Trial& trial);

/// Results of a trial.
struct TrialFigures {
  /// Root mean square of the force between 5 and 500 Hz, at rest; 0 without rest. Where the device drives a torque, with the
  /// torque as a force at the tool's turning radius.
  double rest_n = 0.0;
  bool thrown_off = false;    ///< a device without a hand was driven off its place; `rest_n` is then of its whole stay
  double hum_m_per_s2 = 0.0;  ///< [m/s²] acceleration of the mass of the device by it: felt by skin
  double rough_n = 0.0;       ///< root mean square from 100 to 500 Hz, in motion in contact, away from events
  double most_n = 0.0;        ///< largest force on the hand
  double most_nm = 0.0;       ///< largest torque of the coupling of a tool, before the limit
  double over_torque = 0.0;   ///< [1] share of ticks with a torque beyond the scene's limit
  double jump_n = 0.0;        ///< largest step of the force in a tick beyond the coupling's, of any cause
  double jump_s = 0.0;        ///< [s] time of that step
  StepCause jump_cause = StepCause::unknown;
  int unexplained_jumps = 0;  ///< of more than `felt_step_n`, without an event
  std::string jump_mode;      ///< mode of the largest change of force in the last of them; empty: none
  double duration_s = 0.0;
  double saturated = 0.0;            ///< [1] share of ticks with a limited force
  double overfull = 0.0;             ///< [1] share of ticks with a limited force and no dominant unyielding level
  std::vector<double> pushed_n;      ///< by mode, largest force in such ticks
  double over_budget = 0.0;          ///< [1] share of ticks whose work budget ended before the proxy's path
  double unborne_n = 0.0;            ///< largest force not borne by any strength for 20 ms (Summary::unborne_lasting_n)
  std::vector<double> injected_j;    ///< by mode
  std::vector<double> dissipated_j;  ///< by mode
  double sampling_gained_j = 0.0;    ///< injected by holding each force for a tick
};

/// Runs the trial on a simulated clock of 1 kHz. A hand tilts a tool by up to 0.1 rad; without a hand it stays upright.
/// Allocates; any thread. Throws SceneError. \param plant  with a mass above 0
TrialFigures try_at(const Scene& scene, const DevicePlant& plant, const CheckPlace& place, const Trial& trial);

}  // namespace palpa
