#include "palpa/loop/loop.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <vector>

#include "palpa/loop/window_feed.h"

namespace palpa {

namespace {

// A kill loses at most the sum of these: 0.1 s at 1 kHz. Larger: more is lost; smaller: the loop blocks on the writer more
// often.
constexpr std::int64_t ticks_between_looks = 32;
constexpr std::int64_t most_pending_ticks = 64;

using Clock = std::chrono::steady_clock;
double microseconds(Clock::duration time) { return std::chrono::duration<double, std::micro>(time).count(); }

void record(Recorder& recorder, const TickFrame& frame, const Session& session) {
  if (frame.tick % ticks_between_looks == 0) recorder.keep_up(most_pending_ticks);
  if (recorder.offer(frame, session)) return;
  recorder.keep_up(0);
  if (!recorder.offer(frame, session)) throw std::length_error("the recorder's ring is smaller than one tick");
}

Probe probe_of(const DeviceState& state) {
  return {.position_m = state.position_m,
          .velocity_m_per_s = state.velocity_m_per_s,
          .valid = state.valid,
          .buttons = state.buttons,
          .turn = state.turn.value_or(Turn{})};
}

}  // namespace

std::int64_t run_simulated(Session& session, SimulatedDevice& device, const LoopOptions& options, Recorder* recorder,
                           const TickObserver& observer, const std::atomic<bool>* stop) {
  const SimulatedHand hand{&session, &device, recorder};
  const HandObserver of_hand = [&](std::size_t, const TickFrame& frame, const Session& felt) { observer(frame, felt); };
  return run_simulated({&hand, 1}, options, observer ? of_hand : HandObserver{}, stop);
}

std::int64_t run_simulated(std::span<const SimulatedHand> hands, const LoopOptions& options, const HandObserver& observer,
                           const std::atomic<bool>* stop) {
  std::vector<std::unique_ptr<GuardedSession>> guarded;
  for (const SimulatedHand& hand : hands) {
    const DeviceLimits limits = hand.device->limits();
    guarded.push_back(std::make_unique<GuardedSession>(
        *hand.session,
        GuardOptions{.max_force_n = limits.max_force_n, .motors = false, .max_torque_nm = limits.max_torque_nm}));
  }
  std::vector<WindowFeed> feeds;
  for (const SimulatedHand& hand : hands) feeds.emplace_back(*hand.session);
  std::vector<DeviceState> states(hands.size());
  std::vector<TickFrame> frames(hands.size());
  const auto now = [&] { return options.time_ticks ? Clock::now() : Clock::time_point{}; };
  const double dt_s = 1.0 / options.rate_hz;
  std::int64_t tick = 0;
  for (double t_s = 0.0; t_s < options.duration_s; ++tick) {
    const Clock::time_point begin = now();
    for (std::size_t h = 0; h < hands.size(); ++h) {
      states[h] = hands[h].device->read();
      feeds[h].lay_for(probe_of(states[h]), dt_s);
    }
    const Clock::time_point was_read = now();
    Clock::time_point was_felt = was_read;
    for (std::size_t h = 0; h < hands.size(); ++h) {
      const Clock::time_point begin_tick = was_felt;
      frames[h] = guarded[h]->tick(tick, t_s, dt_s, probe_of(states[h]));
      was_felt = now();
      frames[h].tick_us = microseconds(was_felt - begin_tick);
    }
    for (std::size_t h = 0; h < hands.size(); ++h)
      hands[h].device->write(frames[h].command.force_n, frames[h].command.torque_nm);
    const double device_us = microseconds((was_read - begin) + (now() - was_felt));

    // Successive times differ by at most a factor of two (but for the first), so the difference is exact, and the device's own
    // clock has equal bits.
    const double next_s = static_cast<double>(tick + 1) / options.rate_hz;
    for (std::size_t h = 0; h < hands.size(); ++h) {
      frames[h].device_us = device_us;
      if (hands[h].recorder) record(*hands[h].recorder, frames[h], *hands[h].session);
      if (observer) observer(h, frames[h], *hands[h].session);
      hands[h].device->advance(next_s - t_s);
    }
    t_s = next_s;
    if (stop && stop->load(std::memory_order_relaxed)) return tick + 1;
  }
  return tick;
}

}  // namespace palpa
