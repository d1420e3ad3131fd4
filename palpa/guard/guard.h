// Guard between a tick's force and a device's motors: a state machine without a clock of its own.
#pragma once

#include "palpa/guard/guard_state.h"
#include "palpa/guard/wrench.h"

namespace palpa {

/// Input of the guard in one tick.
struct GuardInput {
  Vec3 force_n;              ///< coupling force after release and impact
  Vec3 probe_step_m;         ///< displacement of the probe since the last tick
  double time_step_s = 0.0;  ///< > 0
  bool usable = true;        ///< the probe is valid
  std::uint32_t buttons = 0;
  std::uint32_t circumstances = 0;  ///< bits of Circumstance
  double gained_j = 0.0;            ///< energy injected by holding the force for a tick, booked to no mode
  // Of a tool with an orientation:
  Vec3 torque_nm{};               ///< about the device's point, after release and impact
  Vec3 probe_turn_step_rad{};     ///< rotation of the probe since the last tick
  double turning_radius_m = 1.0;  ///< > 0: of the tool
  double reach_m = 0.0;           ///< largest lever of the tool
};

/// Guard: the last stage before a motor. Only results of `tick` or `pass` are ever sent.
///
/// Without motors (a simulated hand) it is the limit alone: `pass`. With motors it is the state machine of docs/safety.md:
///
///     waiting ──► ramp ──► on          every state ──► falling ──► waiting      (a fault; after a panic: off)
///                  │        │          ramp, on ──► letting go ──► waiting      (view, map or clutch moves; dead-man let go)
///
/// Force and torque share its state, ramp, falls and warmth. Each is shortened to its own limit, keeping its direction; the
/// torque may grow and turn by the tool's turning radius times the slew limit of the force.
///
/// Its time comes from its input, so equal inputs give equal commands. Allocates nothing; one thread.
class Guard {
 public:
  /// The limit alone.
  /// \param max_force_n  [N] >= 0: the smaller of the scene's and the device's limit; any other value allows no force
  /// A torque is not sent.
  explicit Guard(double max_force_n) noexcept;
  explicit Guard(const GuardOptions& options) noexcept;

  struct Passed {
    Vec3 command_n;     ///< never longer than the limit, rounding included
    Vec3 command_nm{};  ///< likewise
    GuardState state = GuardState::pass;
    GuardCause cause = GuardCause::none;  ///< of any state but pass, limited or damped
    bool begins = false;                  ///< once per return: contact restarts with the proxy on the probe
    bool brakes = false;                  ///< the device's brake should hold the hand
  };

  /// Passes a force and a torque [N·m], shortens each to its limit (keeping its direction), or, if one is not finite, returns
  /// zero and reports a fault. The torque is zero without motors for it.
  Passed pass(const Vec3& force_n, const Vec3& torque_nm = {}) const noexcept;
  /// Command of this tick. Without motors `pass` of force and torque.
  Passed tick(const GuardInput& input) noexcept;
  /// Sets the limits [N], [N·m] of a changed scene, within the device's.
  void limit_to(double max_force_n, double max_torque_nm = 0.0) noexcept;

  /// Warmth of the motors [1]: 1 is that of their continuous force.
  double warmth() const noexcept { return warmth_; }
  const GuardOptions& options() const noexcept { return options_; }

 private:
  enum class Phase : std::uint8_t { waiting, ramp, on, pausing, falling, off };

  GuardCause fault_of(const GuardInput& input) noexcept;
  GuardCause pause_of(const GuardInput& input) const noexcept;
  void enter(Phase phase, GuardCause cause) noexcept;
  Passed next(const GuardInput& input) noexcept;
  Passed wait(const GuardInput& input, GuardCause held_by) noexcept;
  Passed feel(const GuardInput& input) noexcept;
  Passed fallen_to(double left, double time_step_s) const noexcept;
  double limit_n(double time_step_s) const noexcept;
  double limit_nm(double most_n) const noexcept;
  void warm_up(double time_step_s) noexcept;
  Wrench damping(const GuardInput& input) noexcept;

  GuardOptions options_;
  Phase phase_ = Phase::waiting;
  GuardCause cause_ = GuardCause::start;
  Wrench sent_;              // last command
  Wrench falls_from_;        // command at the start of a fall or release
  double in_phase_s_ = 0.0;  // since the phase began; waiting: duration of small forces
  double steady_s_ = 0.0;    // waiting: since the force left `steady_`
  Wrench steady_;            // waiting: reference of a constant force
  int fallen_ = 0;           // [1] ticks of a fall
  bool has_begun_ = false;   // waiting: the session has restarted
  bool is_fast_ = false;     // the hand was above the largest speed and is not yet below half of it
  Vec3 velocity_m_per_s_;    // of the probe, over the last milliseconds
  Vec3 turning_rad_per_s_;   // likewise
  double gained_j_ = 0.0;    // observed energy
  double warmth_ = 0.0;
};

}  // namespace palpa
