#include "palpa/loop/loop.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>

namespace palpa {

namespace {

// A kill loses at most the sum of these: 0.1 s at 1 kHz. Larger: more is lost; smaller: the loop waits for the writer more
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

double let_through_n(const Scene& scene, double device_max_force_n) noexcept {
  return std::min(scene.coupling.max_force_n, device_max_force_n);
}

GuardedSession::GuardedSession(Session& session, double device_max_force_n) noexcept
    : session_(session),
      guard_(let_through_n(session.scene(), device_max_force_n)),
      impact_(session.scene().coupling.impact_ns_per_m) {
  session.let_through(let_through_n(session.scene(), device_max_force_n));
}

TickFrame GuardedSession::tick(std::int64_t number, double t_s, double dt_s, const Probe& probe) noexcept {
  TickFrame frame{.tick = number, .t_s = t_s, .dt_s = dt_s, .result = session_.tick(probe, dt_s), .buttons = probe.buttons};
  // A recording holds what the device showed, usable or not: so it can be felt again.
  frame.result.probe_m = probe.position_m;
  if (probe.velocity_m_per_s) frame.result.probe_velocity_m_per_s = *probe.velocity_m_per_s;
  const bool usable = probe.valid && frame.result.status != TickStatus::bad_input;
  const Guard::Passed passed = guard_.pass(frame.result.force_n);
  frame.guard = passed.state;
  const bool is_released = std::ranges::any_of(
      session_.events(), [](const SessionEvent& event) { return event.kind == SessionEventKind::break_through; });
  if (usable && passed.state != GuardState::fault) {
    const double by_hand_n = session_.scene().coupling.stiffness_n_per_m * norm(frame.result.probe_step_m);
    const bool has_let_go = frame.result.energy.let_go_j > 0.0;
    const Vec3 falling_n = release_.shape(passed.command_n, is_released, by_hand_n, dt_s, has_let_go);
    frame.snap_n = release_.snap_n();
    frame.command_n = guard_.pass(impact_.shape(falling_n, session_, frame.result.probe_step_m, dt_s)).command_n;
  } else {
    release_.reset();
    impact_.reset();
  }
  frame.result.energy.work_on_hand_j = dot(held_command_n_, frame.result.probe_step_m);
  frame.result.energy.held_back_j = dot(held_force_n_ - held_command_n_, frame.result.probe_step_m);
  held_force_n_ = frame.result.force_n;
  held_command_n_ = frame.command_n;
  return frame;
}

std::int64_t run_simulated(Session& session, SimulatedDevice& device, const LoopOptions& options, Recorder* recorder,
                           const TickObserver& observer, const std::atomic<bool>* stop) {
  GuardedSession guarded(session, device.limits().max_force_n);
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
                                    .buttons = state.buttons});
    const Clock::time_point was_felt = now();
    device.write(frame.command_n);
    frame.tick_us = microseconds(was_felt - was_read);
    frame.device_us = microseconds((was_read - begin) + (now() - was_felt));

    if (recorder) record(*recorder, frame, session);
    if (observer) observer(frame, session);

    // Neighbouring times differ by at most a factor of two (the first apart), so the difference is
    // exact, and the device's own clock shows the same bits.
    const double next_s = static_cast<double>(tick + 1) / options.rate_hz;
    device.advance(next_s - t_s);
    t_s = next_s;
    if (stop && stop->load(std::memory_order_relaxed)) return tick + 1;
  }
  return tick;
}

}  // namespace palpa
