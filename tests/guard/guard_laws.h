// The limiter's promises (docs/safety.md), checked from its inputs and commands alone, and hostile hands.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>

#include "palpa/guard/guard.h"

namespace palpa::test {

/// Checks one limiter, tick by tick, from its options and inputs; of its own report only the order of its states.
class Judge {
 public:
  explicit Judge(const GuardOptions& options) : options_(options) {}

  /// Empty, or the broken promise.
  const char* broken_by(const GuardInput& in, const Guard& guard, const Guard::Passed& out) {
    const char* broken = judge(in, guard, out);
    last_n_ = out.command_n;
    last_nm_ = out.command_nm;
    last_state_ = out.state;
    return broken;
  }

 private:
  static bool has(const GuardInput& in, Circumstance circumstance) { return (in.circumstances & bit_of(circumstance)) != 0; }

  const char* judge(const GuardInput& in, const Guard& guard, const Guard::Passed& out) {
    const double sent_n = norm(out.command_n), sent_nm = norm(out.command_nm);
    if (!is_finite(out.command_n) || !is_finite(out.command_nm)) return "a command is finite";
    if (sent_n > options_.max_force_n || sent_nm > options_.max_torque_nm) return "a command is within the limit";
    const double slew_n = options_.slew_n_per_s * in.time_step_s * (1 + 1e-9);
    if (far_from_last(out.command_n, last_n_) > slew_n + 1e-12 ||
        far_from_last(out.command_nm, last_nm_) > in.turning_radius_m * slew_n + 1e-12)
      return "a command grows and turns no faster than the slew limit";
    const bool pushes = sent_n > 0 || sent_nm > 0, grows = sent_n > norm(last_n_) || sent_nm > norm(last_nm_);
    if (!(guard.warmth() <= 1.0 + 1e-9)) return "the motors get no warmer than what they bear for ever";

    const bool not_a_number = !is_finite(in.force_n) || !is_finite(in.torque_nm);
    const bool fault = not_a_number || !in.usable || has(in, Circumstance::panic) || has(in, Circumstance::device_fault) ||
                       has(in, Circumstance::link_lost) || has(in, Circumstance::late) || has(in, Circumstance::stops) ||
                       has(in, Circumstance::other_hand) || has(in, Circumstance::link_closed);
    const bool pause = has(in, Circumstance::view_moves) || has(in, Circumstance::link_stale) ||
                       (options_.dead_man_buttons != 0 && (in.buttons & options_.dead_man_buttons) == 0);
    if (not_a_number && pushes) return "what is not finite is zero at once";
    faulty_ticks_ = fault ? faulty_ticks_ + 1 : 0;
    const bool is_kept = sent_n > norm(last_n_) / 4 + 1e-15 || sent_nm > norm(last_nm_) / 4 + 1e-15;
    if (fault && is_kept && faulty_ticks_ == 1) return "a fault takes away three quarters at once";
    if (faulty_ticks_ >= 3 && pushes) return "a fault ends at zero within three ticks";
    paused_s_ = pause || fault ? paused_s_ + in.time_step_s : 0.0;
    overdue_ticks_ = paused_s_ > 0.05 + 1e-9 ? overdue_ticks_ + 1 : 0;  // a fault in its last tick takes three more
    if (overdue_ticks_ > 3 && pushes) return "a pause ends at zero within 50 ms and three ticks";
    // For any mean of the velocity: after 25 ms of a constant velocity the mean equals it.
    const bool steps = in.usable && is_finite(in.probe_step_m);
    const Vec3 velocity = steps ? in.probe_step_m / in.time_step_s : Vec3{};
    const Vec3 turning = in.usable && is_finite(in.probe_turn_step_rad) ? in.probe_turn_step_rad / in.time_step_s : Vec3{};
    const double speed = std::max(norm(velocity), in.reach_m * norm(turning));
    const bool is_same = speed > 1.5 * options_.max_speed_m_per_s && distance(velocity, last_velocity_) < 1e-6 * speed &&
                         in.reach_m * distance(turning, last_turning_) < 1e-6 * speed;
    last_velocity_ = velocity;
    last_turning_ = turning;
    fast_s_ = is_same ? fast_s_ + in.time_step_s : 0.0;
    fast_ticks_ = fast_s_ > 0.025 ? fast_ticks_ + 1 : 0;
    if (fast_ticks_ > 3 && pushes) return "a hand that is too fast is let go of within three ticks";
    if ((fault || pause) && grows) return "nothing grows while something is wrong";

    if (has(in, Circumstance::panic)) is_off_ = true;
    const bool was_silent = last_n_ == Vec3{} && last_nm_ == Vec3{};
    if (was_silent && !has(in, Circumstance::panic) && has(in, Circumstance::resume)) is_off_ = false;
    if (is_off_ && grows) return "after a panic nothing goes out until a person says so";

    // Recovery: from zero, with a reset session, by the ramp.
    if (fault || pause) {
      allowed_s_ = 0.0;
      is_returning_ = true;
      has_begun_ = false;
    } else if (out.begins) {
      if (pushes) return "what is felt begins anew at zero";
      has_begun_ = true;
      allowed_s_ = 0.0;
      is_returning_ = true;
    } else {
      allowed_s_ += in.time_step_s;
    }
    if (is_returning_ && grows) {
      if (!has_begun_) return "nothing returns before what is felt has begun anew";
      if (allowed_s_ < 0.004) return "nothing returns before the gate has opened";
      const double share = std::min(1.0, allowed_s_ / options_.ramp_s) * (1 + 1e-9);
      if (sent_n > options_.max_force_n * share || sent_nm > options_.max_torque_nm * share)
        return "what returns follows the ramp";
    }
    if (!may_follow(last_state_, out.state)) return "a state follows another as the table says";
    return nullptr;
  }

  static double far_from_last(const Vec3& command, const Vec3& last) {
    const double square = norm_squared(last);
    const double share = square > 0 ? std::min(1.0, std::max(0.0, dot(command, last) / square)) : 0.0;
    return distance(command, share * last);
  }

  // The table of docs/safety.md.
  static bool may_follow(GuardState before, GuardState state) {
    using S = GuardState;
    const auto feels = [](S s) { return s == S::pass || s == S::limited || s == S::damped; };
    if (state == S::fault || before == state) return true;
    switch (before) {
      case S::waiting: return state == S::ramp || state == S::falling;
      case S::ramp: return feels(state) || state == S::falling;
      case S::falling: return state == S::waiting || state == S::off;
      case S::fault: return state == S::waiting || state == S::falling || state == S::off;
      case S::off: return state == S::waiting;
      default: return feels(state) || state == S::falling;
    }
  }

  GuardOptions options_;
  Vec3 last_n_, last_nm_;
  GuardState last_state_ = GuardState::waiting;
  Vec3 last_velocity_, last_turning_;
  int faulty_ticks_ = 0, overdue_ticks_ = 0, fast_ticks_ = 0;
  double paused_s_ = 0.0, allowed_s_ = 0.0, fast_s_ = 0.0;
  bool is_returning_ = true, has_begun_ = false, is_off_ = false;
};

/// A hand and a program with every fault, in pieces of random length.
class RandomHand {
 public:
  explicit RandomHand(std::uint64_t seed) : random_(seed) {}

  GuardOptions options() {
    GuardOptions o{.max_force_n = log_between(0.5, 20.0)};
    if (chance(0.5)) o.continuous_force_n = o.max_force_n * between(0.05, 1.0);
    if (chance(0.5)) o.max_damping_ns_per_m = log_between(0.1, 30.0);
    if (chance(0.3)) o.dead_man_buttons = 1;
    o.thermal_s = log_between(1.0, 60.0);
    o.slew_n_per_s = log_between(50.0, 5000.0);
    o.ramp_s = log_between(0.1, 2.0);
    o.device_damping_ns_per_m = between(0.0, 1.0);
    if (chance(0.7)) o.max_torque_nm = log_between(0.01, 2.0);
    if (chance(0.5)) o.max_turn_damping_nms_per_rad = log_between(1e-4, 0.1);
    radius_m_ = log_between(1e-3, 0.3);
    reach_m_ = radius_m_ * log_between(0.3, 10.0);
    return o;
  }
  GuardInput next() {
    if (--left_ <= 0) begin_stretch();
    GuardInput in{.time_step_s = dt_s_, .buttons = buttons_, .circumstances = circumstances_};
    if (chance(0.001)) in.time_step_s *= std::floor(log_between(2.0, 40.0));
    const double wild = chance(0.01) ? 30.0 : 1.0;
    force_n_ += (wild * roughness_n_) * vector();
    in.force_n = is_quiet_ ? 0.1 * vector() : force_n_;
    in.probe_step_m = in.time_step_s * (goes_one_way_ ? way_m_per_s_ : speed_m_per_s_ * vector());
    in.gained_j = between(-1e-5, gain_j_);
    in.turning_radius_m = radius_m_;
    in.reach_m = reach_m_;
    torque_nm_ += (radius_m_ * wild * roughness_n_) * vector();
    in.torque_nm = is_quiet_ ? 0.1 * radius_m_ * vector() : torque_nm_;
    in.probe_turn_step_rad = in.time_step_s / reach_m_ * (goes_one_way_ ? turning_m_per_s_ : speed_m_per_s_ * vector());
    if (chance(rarely_)) in.torque_nm.x = odd();
    if (chance(rarely_)) in.probe_turn_step_rad.y = odd();
    if (chance(rarely_)) in.force_n.y = odd();
    if (chance(rarely_)) in.usable = false;
    if (chance(rarely_)) in.probe_step_m.z = odd();
    if (chance(rarely_)) in.gained_j = odd();
    for (int bit = 0; bit < 6; ++bit) in.circumstances ^= chance(rarely_) ? 1u << bit : 0u;
    return in;
  }

 private:
  void begin_stretch() {
    left_ = static_cast<int>(log_between(1.0, 3000.0));
    force_n_ = log_between(0.01, 100.0) * vector();
    roughness_n_ = log_between(1e-4, 1.0);
    speed_m_per_s_ = log_between(1e-3, 2.0);
    goes_one_way_ = chance(0.1);
    way_m_per_s_ = log_between(0.1, 10.0) * vector();
    turning_m_per_s_ = log_between(0.1, 10.0) * vector();
    torque_nm_ = log_between(0.01, 100.0) * radius_m_ * vector();
    gain_j_ = log_between(1e-7, 1e-2);
    rarely_ = chance(0.7) ? 0.0 : log_between(1e-4, 0.1);
    is_quiet_ = chance(0.6);
    buttons_ = chance(0.8) ? 1u : 0u;
    circumstances_ = 0;
    for (int bit = 0; bit < 5; ++bit) circumstances_ |= chance(0.03) ? 1u << bit : 0u;
    if (chance(0.03)) circumstances_ |= bit_of(Circumstance::stops);
    for (const Circumstance rare : {Circumstance::other_hand, Circumstance::link_stale, Circumstance::link_closed})
      if (chance(0.03)) circumstances_ |= bit_of(rare);
    if (chance(0.3)) circumstances_ |= bit_of(Circumstance::resume);
    dt_s_ = 1.0 / std::array{500.0, 1000.0, 4000.0, 10000.0}[random_() % 4];
  }
  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  bool chance(double share) { return unit() < share; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  double log_between(double low, double high) { return low * std::exp(unit() * std::log(high / low)); }
  Vec3 vector() {
    const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
    return {x, y, z};
  }
  double odd() {
    const double oddities[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e300,
                               1e300};
    return oddities[random_() % 4];
  }

  std::mt19937_64 random_;
  int left_ = 0;
  Vec3 force_n_, torque_nm_;
  double radius_m_ = 0.03, reach_m_ = 0.1;
  double roughness_n_ = 0, speed_m_per_s_ = 0, gain_j_ = 0, rarely_ = 0, dt_s_ = 1e-3;
  Vec3 way_m_per_s_, turning_m_per_s_;
  bool is_quiet_ = false, goes_one_way_ = false;
  std::uint32_t buttons_ = 0, circumstances_ = 0;
};

}  // namespace palpa::test
