#include "palpa/guard/guard.h"

#include <algorithm>
#include <cmath>

namespace palpa {

namespace {

// A force is small below this, and so is a torque below its product with the turning radius. Larger: a start with a tug;
// smaller: light touches keep the gate shut.
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
  options_.max_torque_nm = usable_limit(options.max_torque_nm);
}

void Guard::limit_to(double max_force_n, double max_torque_nm) noexcept {
  options_.max_force_n = usable_limit(max_force_n);
  options_.max_torque_nm = usable_limit(max_torque_nm);
}

Guard::Passed Guard::pass(const Vec3& force_n, const Vec3& torque_nm) const noexcept {
  if (!is_finite(force_n) || !is_finite(torque_nm))
    return {.command_n = {}, .state = GuardState::fault, .cause = GuardCause::not_finite};
  const Vec3 turns_nm = options_.max_torque_nm > 0.0 ? torque_nm : Vec3{};
  if (norm(force_n) <= options_.max_force_n && norm(turns_nm) <= options_.max_torque_nm)
    return {.command_n = force_n, .command_nm = turns_nm, .state = GuardState::pass};
  return {.command_n = within(force_n, options_.max_force_n),
          .command_nm = within(turns_nm, options_.max_torque_nm),
          .state = GuardState::limited};
}

Guard::Passed Guard::tick(const GuardInput& input) noexcept {
  if (!options_.motors) return pass(input.force_n, input.torque_nm);
  const Passed passed = next(input);
  sent_ = {passed.command_n, passed.command_nm};
  warm_up(input.time_step_s);
  return passed;
}

// Warmth approaches the equilibrium of this command exponentially. It is that of the warmest motors: those of the torque bear
// the same share of their limit for ever as those of the force.
void Guard::warm_up(double time_step_s) noexcept {
  const double bears_n = options_.continuous_force_n;
  const double bears_nm = limit_nm(std::min(bears_n, options_.max_force_n));
  double leads_to = std::isinf(bears_n) ? 0.0 : bears_n > 0.0 ? norm_squared(sent_.force_n) / (bears_n * bears_n) : 1.0;
  if (!std::isinf(bears_n) && bears_nm > 0.0)
    leads_to = std::max(leads_to, norm_squared(sent_.torque_nm) / (bears_nm * bears_nm));
  warmth_ = leads_to + (warmth_ - leads_to) * std::exp(-time_step_s / options_.thermal_s);
}

// Fault of this tick, the worst first.
GuardCause Guard::fault_of(const GuardInput& input) noexcept {
  const bool steps = input.usable && is_finite(input.probe_step_m);
  const double share = std::min(1.0, input.time_step_s / velocity_s);
  velocity_m_per_s_ = steps ? velocity_m_per_s_ + share * (input.probe_step_m / input.time_step_s - velocity_m_per_s_) : Vec3{};
  const bool turns = input.usable && is_finite(input.probe_turn_step_rad);
  turning_rad_per_s_ =
      turns ? turning_rad_per_s_ + share * (input.probe_turn_step_rad / input.time_step_s - turning_rad_per_s_) : Vec3{};
  const double speed_m_per_s = std::max(norm(velocity_m_per_s_), input.reach_m * norm(turning_rad_per_s_));
  is_fast_ = speed_m_per_s > (is_fast_ ? slow_share : 1.0) * options_.max_speed_m_per_s;

  const auto is = [&](Circumstance circumstance) { return (input.circumstances & bit_of(circumstance)) != 0; };
  if (is(Circumstance::panic)) return GuardCause::panic;
  if (is(Circumstance::stops)) return GuardCause::stops;
  if (is(Circumstance::link_lost)) return GuardCause::link_lost;
  if (is(Circumstance::device_fault)) return GuardCause::device_fault;
  if (is(Circumstance::link_closed)) return GuardCause::link_closed;
  if (!input.usable) return GuardCause::no_position;
  if (is(Circumstance::late)) return GuardCause::late;
  if (is(Circumstance::other_hand)) return GuardCause::other_hand;
  return is_fast_ ? GuardCause::speed : GuardCause::none;
}

// Reason for zero force without a fault.
GuardCause Guard::pause_of(const GuardInput& input) const noexcept {
  if ((input.circumstances & bit_of(Circumstance::view_moves)) != 0) return GuardCause::view_moves;
  if ((input.circumstances & bit_of(Circumstance::link_stale)) != 0) return GuardCause::link_stale;
  if (options_.dead_man_buttons != 0 && (input.buttons & options_.dead_man_buttons) == 0) return GuardCause::dead_man;
  return GuardCause::none;
}

void Guard::enter(Phase phase, GuardCause cause) noexcept {
  phase_ = phase;
  cause_ = cause;
  falls_from_ = sent_;
  in_phase_s_ = steady_s_ = 0.0;
  fallen_ = 0;
  has_begun_ = false;
  gained_j_ = 0.0;
}

Guard::Passed Guard::next(const GuardInput& input) noexcept {
  const GuardCause fault = fault_of(input);
  const GuardCause pause = pause_of(input);
  const bool has_panicked = phase_ == Phase::off || (phase_ == Phase::falling && cause_ == GuardCause::panic);
  if (!is_finite(input.force_n) || !is_finite(input.torque_nm)) {
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
      Passed passed = fallen_to(left, input.time_step_s);
      passed.brakes = cause_ == GuardCause::speed;
      if (left == 0.0) enter(cause_ == GuardCause::panic ? Phase::off : Phase::waiting, cause_);
      return passed;
    }
    case Phase::pausing: {
      in_phase_s_ += input.time_step_s;
      const double left = std::max(0.0, 1.0 - in_phase_s_ / pause_fall_s);
      const Passed passed = fallen_to(left, input.time_step_s);
      if (left == 0.0) enter(Phase::waiting, cause_);
      return passed;
    }
    case Phase::waiting: return wait(input, fault != GuardCause::none ? fault : pause);
    case Phase::ramp:
    case Phase::on: return feel(input);
  }
  return {.state = GuardState::off, .cause = cause_};
}

// The remaining share of the command at the start of a fall.
Guard::Passed Guard::fallen_to(double left, double time_step_s) const noexcept {
  const double most_n = limit_n(time_step_s);
  return {.command_n = within(left * falls_from_.force_n, most_n),
          .command_nm = within(left * falls_from_.torque_nm, limit_nm(most_n)),
          .state = GuardState::falling,
          .cause = cause_};
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
    steady_ = {};
    return passed;
  }
  const Wrench wanted{input.force_n, options_.max_torque_nm > 0.0 ? input.torque_nm : Vec3{}};
  const auto is_small = [&](const Wrench& wrench) {
    return norm(wrench.force_n) <= small_n && norm(wrench.torque_nm) <= input.turning_radius_m * small_n;
  };
  in_phase_s_ = is_small(wanted) ? in_phase_s_ + input.time_step_s : 0.0;
  if (is_small(wanted - steady_)) {
    steady_s_ += input.time_step_s;
  } else {
    steady_ = wanted;
    steady_s_ = 0.0;
  }
  if (in_phase_s_ >= small_s || steady_s_ >= steady_s) enter(Phase::ramp, cause_);
  return passed;
}

Guard::Passed Guard::feel(const GuardInput& input) noexcept {
  in_phase_s_ += input.time_step_s;
  const double share = phase_ == Phase::ramp ? std::min(1.0, in_phase_s_ / options_.ramp_s) : 1.0;
  const double most_n = limit_n(input.time_step_s), most_nm = limit_nm(most_n);
  const double reach_n = options_.slew_n_per_s * input.time_step_s;
  const Wrench damps = damping(input);
  const Vec3 turns_nm = options_.max_torque_nm > 0.0 ? input.torque_nm : Vec3{};
  const Vec3 wanted_n = share * within(input.force_n + damps.force_n, most_n);
  const Vec3 command_n = within(slewed(wanted_n, sent_.force_n, reach_n), most_n);
  const Vec3 wanted_nm = share * within(turns_nm + damps.torque_nm, most_nm);
  const Vec3 command_nm = within(slewed(wanted_nm, sent_.torque_nm, input.turning_radius_m * reach_n), most_nm);
  const bool is_cut =
      norm(input.force_n) > most_n || norm(turns_nm) > most_nm || command_n != wanted_n || command_nm != wanted_nm;
  const GuardState felt = is_cut ? GuardState::limited : damps != Wrench{} ? GuardState::damped : GuardState::pass;
  const bool is_ramp = phase_ == Phase::ramp;
  if (share == 1.0) phase_ = Phase::on;
  return {.command_n = command_n,
          .command_nm = command_nm,
          .state = is_ramp ? GuardState::ramp : felt,
          .cause = is_ramp ? cause_ : GuardCause::none};
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

// Limit of the torque where that of the force is `most_n`: one share for both.
double Guard::limit_nm(double most_n) const noexcept {
  if (most_n >= options_.max_force_n) return options_.max_torque_nm;
  return most_n / options_.max_force_n * options_.max_torque_nm;
}

// Passivity observer and controller (Hannaford and Ryu, Time-domain passivity control of haptic interfaces, IEEE Trans.
// Robotics and Automation 18(1), 2002), on the ledger of the balance: energy injected by modes is booked there and not damped.
Wrench Guard::damping(const GuardInput& input) noexcept {
  const double takes_out_j = options_.device_damping_ns_per_m * norm_squared(input.probe_step_m) / input.time_step_s;
  const double change_j = input.gained_j - takes_out_j;
  gained_j_ = std::max(0.0, gained_j_ + (std::isfinite(change_j) ? change_j : 0.0)) * std::exp(-input.time_step_s / account_s);
  const double over = std::clamp(gained_j_ / most_gained_j - 1.0, 0.0, 1.0);
  if (over == 0.0) return {};
  const double damping_ns_per_m = std::min(most_damping_ns_per_m, options_.max_damping_ns_per_m);
  Wrench damps{.force_n = -over * damping_ns_per_m * velocity_m_per_s_, .torque_nm = {}};
  if (options_.max_torque_nm > 0.0) {
    // Equal damping in the metric of the tool.
    const double radius_m = input.turning_radius_m;
    const double damping_nms_per_rad = std::min(damping_ns_per_m * radius_m * radius_m, options_.max_turn_damping_nms_per_rad);
    damps.torque_nm = -over * damping_nms_per_rad * turning_rad_per_s_;
  }
  return damps;
}

}  // namespace palpa
