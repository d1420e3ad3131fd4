#include "palpa/loop/loop.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>

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

}  // namespace

std::int64_t run_simulated(Session& session, SimulatedDevice& device, const LoopOptions& options, Recorder* recorder,
                           const TickObserver& observer, const std::atomic<bool>* stop) {
  const DeviceLimits limits = device.limits();
  GuardedSession guarded(
      session, GuardOptions{.max_force_n = limits.max_force_n, .motors = false, .max_torque_nm = limits.max_torque_nm});
  const auto now = [&] { return options.time_ticks ? Clock::now() : Clock::time_point{}; };
  const double dt_s = 1.0 / options.rate_hz;
  std::int64_t tick = 0;
  for (double t_s = 0.0; t_s < options.duration_s; ++tick) {
    const Clock::time_point begin = now();
    const DeviceState state = device.read();
    const Clock::time_point was_read = now();
    TickFrame frame = guarded.tick(tick, t_s, dt_s,
                                   {.position_m = state.position_m,
                                    .velocity_m_per_s = state.velocity_m_per_s,
                                    .valid = state.valid,
                                    .buttons = state.buttons,
                                    .turn = state.turn.value_or(Turn{})});
    const Clock::time_point was_felt = now();
    device.write(frame.command.force_n, frame.command.torque_nm);
    frame.tick_us = microseconds(was_felt - was_read);
    frame.device_us = microseconds((was_read - begin) + (now() - was_felt));

    if (recorder) record(*recorder, frame, session);
    if (observer) observer(frame, session);

    // Successive times differ by at most a factor of two (but for the first), so the difference is exact, and the device's own
    // clock has equal bits.
    const double next_s = static_cast<double>(tick + 1) / options.rate_hz;
    device.advance(next_s - t_s);
    t_s = next_s;
    if (stop && stop->load(std::memory_order_relaxed)) return tick + 1;
  }
  return tick;
}

}  // namespace palpa
