// The guard between a tick's force and a device's motors: a state machine on told time.
#pragma once

#include "palpa/loop/loop.h"

namespace palpa {

/// What the guard is told of a tick.
struct GuardInput {
  Vec3 force_n;              ///< what is to be sent
  Vec3 probe_step_m;         ///< the way of the probe since the last tick
  double time_step_s = 0.0;  ///< > 0
  bool usable = true;        ///< the probe can be trusted
  std::uint32_t buttons = 0;
  std::uint32_t circumstances = 0;  ///< bits of Circumstance
  double gained_j = 0.0;            ///< energy that holding the force for a tick has brought in, which no mode has booked
};

/// The guard. The last thing before a motor: nothing but what `tick` or `pass` returns is ever sent.
///
/// Without motors (a simulated hand) it is the limit alone: `pass`. With motors it is the state machine of docs/safety.md:
///
///     waiting ──► ramp ──► on          every state ──► falling ──► waiting      (a fault; after a panic: off)
///                  │        │          ramp, on ──► letting go ──► waiting      (view, map or clutch moves; dead-man let go)
///
/// Its time is what it is told, so the same inputs give the same commands. Allocates nothing; one thread.
class Guard {
 public:
  /// The limit alone.
  /// \param max_force_n  [N] >= 0: the smaller of the scene's and the device's limit; a limit that is
  ///                     no such number lets nothing through
  explicit Guard(double max_force_n) noexcept;
  explicit Guard(const GuardOptions& options) noexcept;

  struct Passed {
    Vec3 command_n;  ///< never longer than the limit, rounding included
    GuardState state = GuardState::pass;
    GuardCause cause = GuardCause::none;  ///< of what is not pass, limited or damped
    bool begins = false;                  ///< once per return: what is felt has to begin anew, with the proxy on the probe
    bool brakes = false;                  ///< the device should hold the hand by its brake, if it has one
  };

  /// Lets a force through, shortens it to the limit (keeping its direction), or, for anything that is not
  /// finite, lets nothing through and reports a fault.
  Passed pass(const Vec3& force_n) const noexcept;
  /// What is to be sent in this tick. Without motors `pass` of the force.
  Passed tick(const GuardInput& input) noexcept;
  /// A scene was changed: its limit holds from here on, as far as the device's allows.
  void limit_to(double max_force_n) noexcept;

  /// How warm the motors are [1]: 1 is what they bear for ever.
  double warmth() const noexcept { return warmth_; }
  const GuardOptions& options() const noexcept { return options_; }

 private:
  enum class Phase : std::uint8_t { waiting, ramp, on, letting_go, falling, off };

  GuardCause fault_of(const GuardInput& input) noexcept;
  GuardCause pause_of(const GuardInput& input) const noexcept;
  void enter(Phase phase, GuardCause cause) noexcept;
  Passed next(const GuardInput& input) noexcept;
  Passed wait(const GuardInput& input, GuardCause held_by) noexcept;
  Passed feel(const GuardInput& input) noexcept;
  double limit_n(double time_step_s) const noexcept;
  Vec3 damping_n(const GuardInput& input) noexcept;

  GuardOptions options_;
  Phase phase_ = Phase::waiting;
  GuardCause cause_ = GuardCause::start;
  Vec3 sent_n_;              // last
  Vec3 falls_from_n_;        // what was sent when a fall began, or what is being let go
  double in_phase_s_ = 0.0;  // since the phase began; waiting: of forces that were small
  double steady_s_ = 0.0;    // waiting: since the force left `steady_n_`
  Vec3 steady_n_;            // waiting: a force that has not changed much since
  int fallen_ = 0;           // ticks of a fall
  bool has_begun_ = false;   // waiting: the session was told to begin anew
  bool is_fast_ = false;     // the hand was above the largest speed and is not yet below half of it
  Vec3 velocity_m_per_s_;    // of the probe, over the last milliseconds
  double gained_j_ = 0.0;    // the passivity observer's account
  double warmth_ = 0.0;
};

}  // namespace palpa
