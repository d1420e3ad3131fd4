#include <algorithm>
#include <utility>

#include "palpa/loop/break_through_filter.h"
#include "palpa/loop/guard.h"
#include "palpa/loop/impact.h"
#include "palpa/loop/loop.h"

namespace palpa {

namespace {

// The smaller of two limits; NaN if either is.
double lesser_n(double scene_n, double device_n) noexcept { return scene_n < device_n ? scene_n : device_n; }

}  // namespace

GuardOptions guard_options_for(const DeviceLimits& limits, double scene_max_force_n) noexcept {
  return {.max_force_n = lesser_n(scene_max_force_n, limits.max_force_n),
          .continuous_force_n = limits.continuous_force_n,
          .max_damping_ns_per_m = limits.max_damping_ns_per_m,
          .device_damping_ns_per_m = limits.damping_ns_per_m};
}

double force_limit_n(const Scene& scene, double device_max_force_n) noexcept {
  return lesser_n(scene.coupling().max_force_n, device_max_force_n);
}

// Filters between the session's force and the guard.
struct Shaper {
  explicit Shaper(const Scene& scene) noexcept : impact(scene.coupling().impact_ns_per_m) {}
  void reset() noexcept {
    release.reset();
    impact.reset();
  }

  BreakThroughFilter release;
  Impact impact;
};

struct GuardedSession::State {
  State(Session& felt, const GuardOptions& options) noexcept
      : device_max_force_n(options.max_force_n), session(&felt), guard(options), shaper(felt.scene()) {
    begin_with_limit();
  }

  void begin_with_limit() noexcept {
    const double most_n = force_limit_n(session->scene(), device_max_force_n);
    guard.limit_to(most_n);
    session->set_force_limit(most_n);
  }
  TickFrame tick(TickFrame frame, const Probe& probe) noexcept;
  Command command_for(const TickFrame& frame, bool usable) noexcept;
  Tick exchanged(const Probe& probe, double dt_s) noexcept;

  double device_max_force_n;
  Session* session;
  Session* next = nullptr;
  Guard guard;
  Shaper shaper;
  Vec3 blend_n;  // rest of the step from one scene's force to another's
  Vec3 held_force_n, held_command_n;
  bool brakes = false;
  bool begins = false;
};

// A tick of the session and, on a switch, of both: the difference is the step of the new force.
Tick GuardedSession::State::exchanged(const Probe& probe, double dt_s) noexcept {
  if (!next) return session->tick(probe, dt_s);
  const Tick last = session->tick(probe, dt_s);
  // The hand's part of the old session's force: a release in this very tick is dropped.
  const Vec3 held_n = guard.pass(held_force_n).command_n;
  const double by_hand_n = session->scene().coupling().stiffness_n_per_m * norm(last.probe_step_m);
  const Vec3 before_n = held_n + shortened(guard.pass(last.force_n).command_n - held_n, by_hand_n);
  session = std::exchange(next, nullptr);
  begin_with_limit();
  shaper.impact.set_gain(session->scene().coupling().impact_ns_per_m);
  const Tick tick = session->tick(probe, dt_s);
  const Vec3 step_n = guard.pass(tick.force_n).command_n - before_n;
  shaper.release.shift(step_n);
  blend_n -= step_n;
  return tick;
}

TickFrame GuardedSession::State::tick(TickFrame frame, const Probe& probe) noexcept {
  if (std::exchange(begins, false)) {
    for (Session* one : {session, next})
      if (one) one->reset();
    shaper.reset();
    blend_n = {};
  }
  frame.result = exchanged(probe, frame.dt_s);
  frame.buttons = probe.buttons;
  frame.command = command_for(frame, probe.valid && frame.result.status != TickStatus::bad_input);
  held_force_n = frame.result.force_n;
  held_command_n = frame.command.force_n;
  return frame;
}

Command GuardedSession::State::command_for(const TickFrame& frame, bool usable) noexcept {
  const Tick& felt = frame.result;
  const Guard::Passed passed = guard.pass(felt.force_n);
  Command command{.guard = passed.state,
                  .cause = passed.cause,
                  .work_on_hand_j = dot(held_command_n, felt.probe_step_m),
                  .withheld_j = dot(held_force_n - held_command_n, felt.probe_step_m)};
  Vec3 wanted_n = felt.force_n;  // unchanged if not finite: the guard reports that
  if (usable && passed.state != GuardState::fault) {
    // The returned part of a withheld force grows gradually, and is no fall either.
    const double by_hand_n = session->scene().coupling().stiffness_n_per_m * norm(felt.probe_step_m) + felt.given_back_n;
    const bool is_released = std::ranges::any_of(
        session->events(), [](const SessionEvent& event) { return event.kind == SessionEventKind::break_through; });
    const Vec3 falling_n =
        shaper.release.shape(passed.command_n, is_released, by_hand_n, frame.dt_s, felt.energy.released_j > 0.0);
    command.snap_n = shaper.release.snap_n();
    const GuardOptions& options = guard.options();
    const double fade_n = options.max_force_n * frame.dt_s / options.ramp_s;
    const double blend = norm(blend_n);
    blend_n = blend > fade_n ? (1.0 - fade_n / blend) * blend_n : Vec3{};
    wanted_n = shaper.impact.shape(falling_n, *session, felt.probe_step_m, frame.dt_s);
    if (blend > 0.0) wanted_n += blend_n;
  } else {
    shaper.reset();
    blend_n = {};
  }
  if (!guard.options().motors) {
    if (usable && passed.state != GuardState::fault) command.force_n = guard.pass(wanted_n).command_n;
    return command;
  }
  const Guard::Passed sent = guard.tick({.force_n = wanted_n,
                                         .probe_step_m = felt.probe_step_m,
                                         .time_step_s = frame.dt_s,
                                         .usable = usable,
                                         .buttons = frame.buttons,
                                         .circumstances = frame.circumstances,
                                         .gained_j = felt.energy.sampling_j + felt.energy.damper_j});
  command.force_n = sent.command_n;
  if (!(sent.state == GuardState::pass && passed.state == GuardState::limited)) command.guard = sent.state;
  command.cause = sent.cause;
  brakes = sent.brakes;
  begins = sent.begins;
  return command;
}

GuardedSession::GuardedSession(Session& session, double device_max_force_n)
    : GuardedSession(session, GuardOptions{.max_force_n = device_max_force_n, .motors = false}) {}
GuardedSession::GuardedSession(Session& session, const GuardOptions& options)
    : state_(std::make_unique<State>(session, options)) {}
GuardedSession::~GuardedSession() = default;

TickFrame GuardedSession::tick(std::int64_t number, double t_s, double dt_s, const Probe& probe,
                               std::uint32_t circumstances) noexcept {
  return state_->tick({.tick = number, .t_s = t_s, .dt_s = dt_s, .circumstances = circumstances}, probe);
}
void GuardedSession::switch_to(Session& next) noexcept { state_->next = &next; }
bool GuardedSession::brakes() const noexcept { return state_->brakes; }
const Session& GuardedSession::session() const noexcept { return *state_->session; }

}  // namespace palpa
