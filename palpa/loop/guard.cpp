#include "palpa/loop/guard.h"

#include <algorithm>
#include <cmath>

namespace palpa {

namespace {

// A force is small below this. Larger: a start with a tug; smaller: light touches keep the gate shut.
constexpr double small_n = 0.2;
// Required duration of a small force. Longer: a pause at the start; shorter: a force that passes through zero opens the gate.
constexpr double small_s = 0.004;
// A constant force (a wind that is everywhere) opens the gate after this. Longer: flows are silent for longer at the start;
// shorter: a hand that presses on meanwhile is pushed.
constexpr double steady_s = 0.5;
// Averaging time of the hand's velocity. Longer: late; shorter: an encoder's step of 55 µm appears as speed.
constexpr double velocity_s = 0.005;
// Share [1] of the largest speed below which a hand is slow again. Larger: it flickers; smaller: longer recovery.
constexpr double slow_share = 0.5;
// Duration of an ordinary release. Longer: a view moves while the force is still there; shorter: a jerk.
constexpr double pause_fall_s = 0.05;
// Fall after a fault: remaining share [1] after one, two, three ticks. Slower: longer in danger; faster: a knock.
constexpr double left_after[] = {1.0 / 4.0, 1.0 / 16.0, 0.0};
// Warmth [1] from which the limit decreases to the motors' continuous force. Higher: more abrupt; lower: strong forces are
// shorter.
constexpr double warm = 0.5;
// Time constant and threshold of the passivity observer. Longer or less: acts on quick strokes, too, which gain (k/2)|Δp|² per
// tick; shorter or more: an oscillation grows further before it is damped.
constexpr double account_s = 0.2;
constexpr double most_gained_j = 0.005;
// Largest damping of the controller [N·s/m]. More: unstable on a handle of 45 g; less: stiff scenes oscillate.
constexpr double most_damping_ns_per_m = 5.0;

// A normalised vector may be a few ulp too long: shortened so that the command never exceeds the limit.
Vec3 within(const Vec3& force_n, double most_n) noexcept {
  constexpr double inside = 1.0 - 0x1p-50;
  return norm(force_n) <= most_n ? force_n : (inside * most_n) * normalized(force_n);
}

// Force nearest to the wanted force within `reach_n` of the segment from zero to the last force: it may fall freely, and grow
// or turn by that much.
Vec3 slewed(const Vec3& wanted_n, const Vec3& last_n, double reach_n) noexcept {
  const double along = norm_squared(last_n);
  const double share = along > 0.0 ? std::clamp(dot(wanted_n, last_n) / along, 0.0, 1.0) : 0.0;
  const Vec3 nearest_n = share * last_n;
  const Vec3 beyond_n = wanted_n - nearest_n;
  const double far_n = norm(beyond_n);
  return far_n <= reach_n ? wanted_n : nearest_n + (reach_n / far_n) * beyond_n;
}

double usable_limit(double most_n) noexcept { return most_n >= 0.0 ? most_n : 0.0; }

}  // namespace

Guard::Guard(double max_force_n) noexcept : Guard(GuardOptions{.max_force_n = max_force_n, .motors = false}) {}

Guard::Guard(const GuardOptions& options) noexcept : options_(options) {
  options_.max_force_n = usable_limit(options.max_force_n);
  options_.continuous_force_n = usable_limit(options.continuous_force_n);
}

void Guard::limit_to(double max_force_n) noexcept { options_.max_force_n = usable_limit(max_force_n); }

Guard::Passed Guard::pass(const Vec3& force_n) const noexcept {
  if (!is_finite(force_n)) return {.command_n = {}, .state = GuardState::fault, .cause = GuardCause::not_finite};
  if (norm(force_n) <= options_.max_force_n) return {.command_n = force_n, .state = GuardState::pass};
  return {.command_n = within(force_n, options_.max_force_n), .state = GuardState::limited};
}

Guard::Passed Guard::tick(const GuardInput& input) noexcept {
  if (!options_.motors) return pass(input.force_n);
  const Passed passed = next(input);
  sent_n_ = passed.command_n;
  // Warmth approaches the equilibrium of this force exponentially.
  const double bears_n = options_.continuous_force_n;
  const double leads_to = std::isinf(bears_n) ? 0.0 : bears_n > 0.0 ? norm_squared(sent_n_) / (bears_n * bears_n) : 1.0;
  warmth_ = leads_to + (warmth_ - leads_to) * std::exp(-input.time_step_s / options_.thermal_s);
  return passed;
}

// Fault of this tick, the worst first.
GuardCause Guard::fault_of(const GuardInput& input) noexcept {
  const bool steps = input.usable && is_finite(input.probe_step_m);
  const double share = std::min(1.0, input.time_step_s / velocity_s);
  velocity_m_per_s_ = steps ? velocity_m_per_s_ + share * (input.probe_step_m / input.time_step_s - velocity_m_per_s_) : Vec3{};
  const double speed_m_per_s = norm(velocity_m_per_s_);
  is_fast_ = speed_m_per_s > (is_fast_ ? slow_share : 1.0) * options_.max_speed_m_per_s;

  const auto is = [&](Circumstance circumstance) { return (input.circumstances & bit_of(circumstance)) != 0; };
  if (is(Circumstance::panic)) return GuardCause::panic;
  if (is(Circumstance::stops)) return GuardCause::stops;
  if (is(Circumstance::link_lost)) return GuardCause::link_lost;
  if (is(Circumstance::device_fault)) return GuardCause::device_fault;
  if (!input.usable) return GuardCause::no_position;
  if (is(Circumstance::late)) return GuardCause::late;
  return is_fast_ ? GuardCause::speed : GuardCause::none;
}

// Reason for zero force without a fault.
GuardCause Guard::pause_of(const GuardInput& input) const noexcept {
  if ((input.circumstances & bit_of(Circumstance::view_moves)) != 0) return GuardCause::view_moves;
  if (options_.dead_man_buttons != 0 && (input.buttons & options_.dead_man_buttons) == 0) return GuardCause::dead_man;
  return GuardCause::none;
}

void Guard::enter(Phase phase, GuardCause cause) noexcept {
  phase_ = phase;
  cause_ = cause;
  falls_from_n_ = sent_n_;
  in_phase_s_ = steady_s_ = 0.0;
  fallen_ = 0;
  has_begun_ = false;
  gained_j_ = 0.0;
}

Guard::Passed Guard::next(const GuardInput& input) noexcept {
  const GuardCause fault = fault_of(input);
  const GuardCause pause = pause_of(input);
  const bool has_panicked = phase_ == Phase::off || (phase_ == Phase::falling && cause_ == GuardCause::panic);
  if (!is_finite(input.force_n)) {
    const bool ends = has_panicked || fault == GuardCause::panic;
    enter(ends ? Phase::off : Phase::waiting, ends ? GuardCause::panic : GuardCause::not_finite);
    return {.state = GuardState::fault, .cause = GuardCause::not_finite};
  }
  if (fault == GuardCause::panic && phase_ == Phase::falling) {
    cause_ = fault;
  } else if (fault == GuardCause::panic && !has_panicked) {
    enter(Phase::falling, fault);
  } else if (fault != GuardCause::none && (phase_ == Phase::ramp || phase_ == Phase::on || phase_ == Phase::pausing)) {
    enter(Phase::falling, fault);
  } else if (pause != GuardCause::none && (phase_ == Phase::ramp || phase_ == Phase::on)) {
    enter(Phase::pausing, pause);
  }

  switch (phase_) {
    case Phase::off:
      if (fault != GuardCause::panic && (input.circumstances & bit_of(Circumstance::resume)) != 0) {
        enter(Phase::waiting, GuardCause::start);
        return wait(input, fault != GuardCause::none ? fault : pause);
      }
      return {.state = GuardState::off, .cause = cause_};
    case Phase::falling: {
      const double left = left_after[fallen_++];
      const Passed passed{.command_n = within(left * falls_from_n_, limit_n(input.time_step_s)),
                          .state = GuardState::falling,
                          .cause = cause_,
                          .brakes = cause_ == GuardCause::speed};
      if (left == 0.0) enter(cause_ == GuardCause::panic ? Phase::off : Phase::waiting, cause_);
      return passed;
    }
    case Phase::pausing: {
      in_phase_s_ += input.time_step_s;
      const double left = std::max(0.0, 1.0 - in_phase_s_ / pause_fall_s);
      const Passed passed{
          .command_n = within(left * falls_from_n_, limit_n(input.time_step_s)), .state = GuardState::falling, .cause = cause_};
      if (left == 0.0) enter(Phase::waiting, cause_);
      return passed;
    }
    case Phase::waiting: return wait(input, fault != GuardCause::none ? fault : pause);
    case Phase::ramp:
    case Phase::on: return feel(input);
  }
  return {.state = GuardState::off, .cause = cause_};
}

// Small-force gate.
Guard::Passed Guard::wait(const GuardInput& input, GuardCause held_by) noexcept {
  if (held_by != GuardCause::none) {
    if (held_by != cause_ || has_begun_) enter(Phase::waiting, held_by);
    return {.state = GuardState::waiting, .cause = cause_, .brakes = held_by == GuardCause::speed};
  }
  Passed passed{.state = GuardState::waiting, .cause = cause_};
  if (!has_begun_) {
    // Old proxy in this tick, new proxy from the next.
    has_begun_ = passed.begins = true;
    steady_n_ = {};
    return passed;
  }
  in_phase_s_ = norm(input.force_n) <= small_n ? in_phase_s_ + input.time_step_s : 0.0;
  if (norm(input.force_n - steady_n_) <= small_n) {
    steady_s_ += input.time_step_s;
  } else {
    steady_n_ = input.force_n;
    steady_s_ = 0.0;
  }
  if (in_phase_s_ >= small_s || steady_s_ >= steady_s) enter(Phase::ramp, cause_);
  return passed;
}

Guard::Passed Guard::feel(const GuardInput& input) noexcept {
  in_phase_s_ += input.time_step_s;
  const double share = phase_ == Phase::ramp ? std::min(1.0, in_phase_s_ / options_.ramp_s) : 1.0;
  const double most_n = limit_n(input.time_step_s);
  const Vec3 damps_n = damping_n(input);
  const Vec3 wanted_n = share * within(input.force_n + damps_n, most_n);
  const Vec3 command_n = within(slewed(wanted_n, sent_n_, options_.slew_n_per_s * input.time_step_s), most_n);
  const GuardState felt = norm(input.force_n) > most_n || command_n != wanted_n ? GuardState::limited
                          : damps_n != Vec3{}                                   ? GuardState::damped
                                                                                : GuardState::pass;
  const bool is_ramp = phase_ == Phase::ramp;
  if (share == 1.0) phase_ = Phase::on;
  return {.command_n = command_n, .state = is_ramp ? GuardState::ramp : felt, .cause = is_ramp ? cause_ : GuardCause::none};
}

double Guard::limit_n(double time_step_s) const noexcept {
  const double most_n = options_.max_force_n;
  const double bears_n = std::min(most_n, options_.continuous_force_n);
  if (bears_n == most_n) return most_n;
  const double cooled = std::clamp((1.0 - warmth_) / (1.0 - warm), 0.0, 1.0);
  // A long tick heats the motors to at most 1 as well.
  const double kept = std::exp(-time_step_s / options_.thermal_s);
  const double just_warm_n = bears_n * std::sqrt((1.0 - kept * warmth_) / (1.0 - kept));
  return std::min(bears_n + cooled * (most_n - bears_n), std::max(bears_n, just_warm_n));
}

// Passivity observer and controller (Hannaford and Ryu, Time-domain passivity control of haptic interfaces, IEEE Trans.
// Robotics and Automation 18(1), 2002), on the ledger of the balance: energy injected by modes is booked there and not damped.
Vec3 Guard::damping_n(const GuardInput& input) noexcept {
  const double takes_out_j = options_.device_damping_ns_per_m * norm_squared(input.probe_step_m) / input.time_step_s;
  const double change_j = input.gained_j - takes_out_j;
  gained_j_ = std::max(0.0, gained_j_ + (std::isfinite(change_j) ? change_j : 0.0)) * std::exp(-input.time_step_s / account_s);
  const double over = std::clamp(gained_j_ / most_gained_j - 1.0, 0.0, 1.0);
  if (over == 0.0) return {};
  return -over * std::min(most_damping_ns_per_m, options_.max_damping_ns_per_m) * velocity_m_per_s_;
}

}  // namespace palpa
