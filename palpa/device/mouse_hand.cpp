#include "palpa/device/mouse_hand.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpa {

namespace {
// Largest control-display ratio [1]. More: resistance is easier to see, but the hand feels stuck; less: it is not visible.
constexpr double largest_ratio = 3.0;
// [s] Longest interval between motions of one movement. Longer: the hand lags behind a slow window; shorter: it stops between.
constexpr double longest_interval_s = 0.1;
// [1] Share of the longest recent interval that remains with each motion: intervals of a busy window vary.
constexpr double kept_share = 0.8;

/// Way, or rotation, slowed by the force, or torque, that it goes against.
/// \param largest  force or torque against which nothing moves
Vec3 slowed(const Vec3& way, const Vec3& force, double largest) noexcept {
  const double strength = norm(force);
  if (!(strength > 0.0)) return way;
  const Vec3 along = force / strength;
  const double against = std::max(0.0, -dot(way, along)), share = std::min(1.0, strength / largest);
  const double taken = share < 1.0 ? 1.0 / (1.0 + (largest_ratio - 1.0) * share) : 0.0;
  return way + (1.0 - taken) * against * along;
}
}  // namespace

void MouseHand::move(const Vec3& way_m) noexcept {
  if (!is_finite(way_m)) return;
  given_.moved_to_m += way_m;
  wanted_.give(given_);
}

void MouseHand::turn(const Vec3& rotation_rad) noexcept {
  if (!is_finite(rotation_rad)) return;
  given_.turned_to = turned_further(given_.turned_to, rotation_rad);
  wanted_.give(given_);
}

void MouseHand::put(const Vec3& at_m) noexcept {
  if (!is_finite(at_m)) return;
  given_.put_at_m = at_m;
  given_.put_from_m = given_.moved_to_m;
  ++given_.puts;
  wanted_.give(given_);
}

void MouseHand::have_mouse(bool is_had) noexcept {
  press(0);
  has_mouse_.store(is_had, std::memory_order_relaxed);
}

bool MouseHand::write(const Vec3& force_n) noexcept { return write(force_n, {}); }

bool MouseHand::write(const Vec3& force_n, const Vec3& torque_nm) noexcept {
  force_n_ = is_finite(force_n) ? force_n : Vec3{};
  torque_nm_ = is_finite(torque_nm) ? torque_nm : Vec3{};
  return true;
}

DeviceState MouseHand::read() noexcept {
  const auto now = options_.now();
  pass(std::chrono::duration<double>(now - passed_to_).count());
  passed_to_ = now;
  const bool has_mouse = has_mouse_.load(std::memory_order_relaxed);
  return {.position_m = position_m_,
          .velocity_m_per_s = velocity_m_per_s_,
          .valid = !std::exchange(was_put_, false),
          .buttons = has_mouse ? buttons_.load(std::memory_order_relaxed) : 0u,
          .time_s = std::chrono::duration<double>(now.time_since_epoch()).count(),
          .fault = has_mouse ? nullptr : "another window has the mouse: the hand is at rest",
          .turn = turn_};
}

void MouseHand::pass(double time_s) noexcept {
  const Wanted& wanted = wanted_.take();
  if (wanted.puts != puts_taken_) {
    puts_taken_ = wanted.puts;
    was_put_ = true;
    position_m_ = shortened(wanted.put_at_m, options_.radius_m);
    spread_m_ = pending_m_ = velocity_m_per_s_ = {};
    taken_m_ = wanted.put_from_m;
  }
  if (wanted.moved_to_m != taken_m_) {
    const bool goes_on = since_motion_s_ <= longest_interval_s;
    interval_s_ = goes_on ? std::max(since_motion_s_, kept_share * interval_s_) : 0.0;
    spread_m_ += wanted.moved_to_m - taken_m_;
    left_s_ = interval_s_;
    since_motion_s_ = 0.0;
  }
  taken_m_ = wanted.moved_to_m;
  if (wanted.turned_to != taken_turn_) {
    turns_to_ = turned_further(turns_to_, rotation_between_rad(taken_turn_, wanted.turned_to));
    taken_turn_ = wanted.turned_to;
  }
  if (!has_mouse_.load(std::memory_order_relaxed)) {
    spread_m_ = pending_m_ = velocity_m_per_s_ = {};
    turns_to_ = turn_;
    return;
  }
  if (!(time_s > 0.0)) return;
  move_on(time_s);
  turn_on(time_s);
}

void MouseHand::move_on(double time_s) noexcept {
  since_motion_s_ += time_s;
  const Vec3 due_m = left_s_ > time_s ? (time_s / left_s_) * spread_m_ : spread_m_;
  left_s_ = std::max(0.0, left_s_ - time_s);
  spread_m_ -= due_m;
  pending_m_ += due_m;
  Vec3 way_m = -std::expm1(-time_s / options_.smoothing_s) * pending_m_;
  pending_m_ -= way_m;
  way_m = slowed(way_m, force_n_, options_.largest_force_n);
  const Vec3 before_m = position_m_;
  position_m_ = shortened(position_m_ + way_m, options_.radius_m);
  velocity_m_per_s_ = (position_m_ - before_m) / time_s;
}

// A turn that the torque holds up is lost, as a motion is.
void MouseHand::turn_on(double time_s) noexcept {
  const Vec3 due_rad = -std::expm1(-time_s / options_.smoothing_s) * rotation_between_rad(turn_, turns_to_);
  const Vec3 turned_rad = slowed(due_rad, torque_nm_, options_.largest_torque_nm);
  turn_ = turned_further(turn_, turned_rad);
  turns_to_ = turned_further(turns_to_, turned_rad - due_rad);
}

}  // namespace palpa
