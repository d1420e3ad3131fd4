#include "app/far_loop.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "app/net_library.h"
#include "palpa/loop/loop.h"
#include "palpa/study/bring_up.h"

namespace palpa::app {
namespace {

// As of LiveLoop: consecutive missed ticks that are a fault of a device with motors.
constexpr std::int64_t late_ticks = 3;

// Messages a tick [1]. More: a flood makes ticks late; fewer: it takes longer to get up to date after a pause.
constexpr int most_taken = 32;

/// Zero force at the end, also of an exception.
class EndsAtNoForce {
 public:
  explicit EndsAtNoForce(Device& device) noexcept : device_(device) {}
  ~EndsAtNoForce() { device_.write({}); }
  EndsAtNoForce(const EndsAtNoForce&) = delete;
  EndsAtNoForce& operator=(const EndsAtNoForce&) = delete;

 private:
  Device& device_;
};

LinkOptions way_back(LinkOptions link) {
  ++link.seed;
  return link;
}

}  // namespace

FarLoop::FarLoop(Device& device, NetClient& client, const HandSideOptions& hand, const FarLoopOptions& options)
    : device_(device),
      client_(client),
      hand_(hand),
      options_(options),
      grip_(options.grip),
      has_motors_(device.limits().has_motors) {
  hand_.set_connected(false);
}

void FarLoop::run(const std::atomic<bool>& stop) {
  DrivenDevice driven(device_);
  const EndsAtNoForce at_the_end(device_);
  const std::unique_ptr<LoopClock> clock = wall_clock();
  const double period_s = 1.0 / options_.rate_hz, begin_s = clock->now_s() + period_s;
  std::int64_t number = 0, last_number = -1;
  while (!stop.load(std::memory_order_relaxed) && static_cast<double>(number) * period_s < options_.duration_s) {
    const double deadline_s = begin_s + static_cast<double>(number) * period_s;
    clock->wait_until_s(deadline_s);
    const double late_s = clock->now_s() - deadline_s;
    const auto missed = static_cast<std::int64_t>(std::max(0.0, std::floor(late_s / period_s)));
    number += missed;
    const double step_s = static_cast<double>(number - last_number) * period_s;
    last_number = number;
    totals_.late.add(1e6 * late_s);
    tick(static_cast<double>(number) * period_s, std::min(step_s, 1.0), missed, driven.has_to_rest());
    ++number;
  }
}

void FarLoop::tick(double t_s, double time_step_s, std::int64_t missed, bool has_to_rest) noexcept {
  const DeviceState state = device_.read();
  const ClutchMapping::Held held = grip_.hold(state, time_step_s);
  std::uint32_t circumstances = 0;
  const auto add = [&](Circumstance circumstance, bool is_so) { circumstances |= is_so ? bit_of(circumstance) : 0u; };
  add(Circumstance::device_fault, state.fault != nullptr);
  add(Circumstance::link_lost, !is_linked_);
  add(Circumstance::late, has_motors_ && missed >= late_ticks);
  add(Circumstance::view_moves, held.moves || is_held_.load(std::memory_order_relaxed));
  add(Circumstance::panic, panics_.load(std::memory_order_relaxed));
  add(Circumstance::resume, resumes_.exchange(false, std::memory_order_relaxed));
  add(Circumstance::stops, has_to_rest);

  connect();
  hand_.begin({held.probe.position_m, held.probe.valid, held.probe.buttons}, time_step_s);
  give(t_s);
  take(t_s);
  const HandTick felt = hand_.feel(circumstances);
  if (felt.brakes != brakes_) device_.brake(brakes_ = felt.brakes);
  is_linked_ = device_.write(grip_.at_device({felt.command_n, {}}).force_n);

  totals_.missed += missed;
  view_ = {felt, t_s, totals_.missed, state.fault};
  count(time_step_s);
  views_.give(view_);
}

// A connection that was closed and opened between two ticks is closed for the hand's side, too.
void FarLoop::connect() noexcept {
  const std::uint32_t open = client_.connection();
  if (open == connection_) return;
  if (connection_ != 0) hand_.set_connected(false);
  if (open != 0) hand_.set_connected(true);
  connection_ = open;
  if (!options_.link) return;
  there_.emplace(*options_.link);
  back_.emplace(way_back(*options_.link));
}

void FarLoop::give(double now_s) noexcept {
  if (connection_ == 0) return;
  for (std::size_t bytes = hand_.give(message_); bytes > 0; bytes = hand_.give(message_)) {
    const std::span<const std::byte> message(message_.data(), bytes);
    if (there_ && may_be_lost(message))
      there_->send(message, now_s);
    else
      client_.send(connection_, message);
  }
  if (!there_) return;
  for (auto message = there_->receive(now_s); !message.empty(); message = there_->receive(now_s))
    client_.send(connection_, message);
}

void FarLoop::take(double now_s) noexcept {
  if (connection_ == 0) return;
  for (int n = 0; n < most_taken; ++n) {
    const std::span<const std::byte> message = client_.receive(connection_);
    if (message.empty()) break;
    if (back_ && may_be_lost(message))
      back_->send(message, now_s);
    else
      take(message);
  }
  if (!back_) return;
  for (auto message = back_->receive(now_s); !message.empty(); message = back_->receive(now_s)) take(message);
}

void FarLoop::take(std::span<const std::byte> message) noexcept {
  const std::optional<MessageHead> head = head_of(message);
  if (hand_.take(message) && head && head->kind == MessageHead::Kind::model) ++totals_.models;
}

void FarLoop::count(double time_step_s) noexcept {
  const HandTick& felt = view_.tick;
  ++totals_.ticks;
  totals_.felt_s += time_step_s;
  totals_.largest_command_n = std::max(totals_.largest_command_n, norm(felt.command_n));
  totals_.work_j += felt.work_j, totals_.sampling_j += felt.sampling_j, totals_.model_j += felt.model_j;
  totals_.link_j += felt.link_j, totals_.released_j += felt.released_j, totals_.stored_j = felt.stored_j;
  totals_.least_account_j = std::min(totals_.least_account_j, felt.account_j);
  if (felt.beyond) ++totals_.beyond;
  if (felt.link == LinkState::up) {
    ++totals_.up;
    totals_.round_trips_s += felt.round_trip_s;
    totals_.age.add(1e6 * felt.model_age_s);
    outage_s_ = -1.0;
  } else if (totals_.up > 0) {
    if (outage_s_ < 0.0) ++totals_.outages, outage_s_ = 0.0;
    outage_s_ += time_step_s;
    totals_.longest_outage_s = std::max(totals_.longest_outage_s, outage_s_);
  }
}

}  // namespace palpa::app
