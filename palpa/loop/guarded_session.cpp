#include <algorithm>
#include <ranges>
#include <utility>

#include "palpa/guard/break_through_filter.h"
#include "palpa/guard/guard.h"
#include "palpa/guard/impact.h"
#include "palpa/guard/wrench.h"
#include "palpa/loop/loop.h"

namespace palpa {

namespace {

// The smaller of two limits; NaN if either is.
double lesser(double of_scene, double of_device) noexcept { return of_scene < of_device ? of_scene : of_device; }

// Rotation of the hand since the last tick [rad]: none of the view's.
Vec3 hand_turn_rad(const TickFrame& frame) noexcept {
  const bool view_moves = (frame.circumstances & bit_of(Circumstance::view_moves)) != 0;
  return view_moves ? Vec3{} : frame.result.probe_turn_step_rad;
}

bool is_hard(const Primitive& level, double coupling_n_per_m) noexcept {
  const bool holds = level.kind == PrimitiveKind::plane || level.kind == PrimitiveKind::corner;
  return holds && level.stiffness_n_per_m > coupling_n_per_m;
}

// Passes on the hard levels that were met in the session's last tick.
void hit(Impact& impact, const Session& session) noexcept {
  for (const SessionEvent& event : session.events()) {
    if (event.kind != SessionEventKind::onset) continue;
    // The last of its rows: the level as it was met.
    const auto rows = session.primitives() | std::views::reverse;
    const auto level = std::ranges::find_if(rows, [&](const PlacedPrimitive& row) {
      return row.primitive.id.mode == event.mode && row.captured.any() && row.captured.value == event.value &&
             is_hard(row.primitive, session.scene().coupling().stiffness_n_per_m);
    });
    if (level != rows.end()) impact.hit({level->primitive.direction, level->primitive.strength_n, level->lever_m});
  }
}

}  // namespace

double force_limit_n(const Scene& scene, double device_max_force_n) noexcept {
  return lesser(scene.coupling().max_force_n, device_max_force_n);
}

double torque_limit_nm(const Scene& scene, double device_max_torque_nm) noexcept {
  return lesser(scene.coupling().max_torque_nm, device_max_torque_nm);
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

// Measures of a tool that the guard needs.
struct ToolSize {
  explicit ToolSize(const Tool& tool) noexcept : turning_radius_m(tool.turning_radius_m()), reach_m(tool.reach_m()) {}
  double turning_radius_m, reach_m;
};

struct GuardedSession::State {
  State(Session& first, const GuardOptions& options)
      : device_max_force_n(options.max_force_n),
        device_max_torque_nm(options.max_torque_nm),
        session(&first),
        tool(Tool(first.scene().tool(), first.scene().coupling())),
        next_tool(tool),
        guard(options),
        shaper(first.scene()) {
    begin_with_limit();
  }

  void begin_with_limit() noexcept {
    const double most_n = force_limit_n(session->scene(), device_max_force_n);
    guard.limit_to(most_n, torque_limit_nm(session->scene(), device_max_torque_nm));
    session->set_force_limit(most_n);
  }
  bool drives_torque() const noexcept { return guard.options().max_torque_nm > 0.0; }
  /// Part of a tick's force and torque that the device can drive.
  Wrench drivable(const Tick& tick) const noexcept { return {tick.force_n, drives_torque() ? tick.torque_nm : Vec3{}}; }
  Wrench within_limits(const Wrench& wrench) const noexcept {
    const Guard::Passed passed = guard.pass(wrench.force_n, wrench.torque_nm);
    return {passed.command_n, passed.command_nm};
  }
  /// Change of the spring's force [N] by the hand's own motion.
  double by_hand_n(const Tick& felt) const noexcept {
    return session->scene().coupling().stiffness_n_per_m *
           length(Motion{felt.probe_step_m, tool.turning_radius_m * felt.probe_turn_step_rad});
  }
  TickFrame tick(TickFrame frame, const Probe& probe) noexcept;
  Command work_of(const TickFrame& frame) const noexcept;
  Command command_for(const TickFrame& frame, bool usable) noexcept;
  Wrench shaped(const TickFrame& frame, const Wrench& passed, double& snap_n) noexcept;
  Tick exchanged(const Probe& probe, double dt_s) noexcept;

  double device_max_force_n, device_max_torque_nm;
  Session* session;
  Session* next = nullptr;
  ToolSize tool, next_tool;
  Guard guard;
  Shaper shaper;
  Wrench blend;  // rest of the step from one scene's command to another's
  Wrench held;   // force and torque of the last tick, the torque also where the device drives none
  Wrench held_command;
  bool brakes = false;
  bool begins = false;
};

// A tick of the session and, on a switch, of both: the difference is the step of the new force.
Tick GuardedSession::State::exchanged(const Probe& probe, double dt_s) noexcept {
  if (!next) return session->tick(probe, dt_s);
  const Tick last = session->tick(probe, dt_s);
  // The hand's part of the old session's force: a release in this very tick is dropped.
  const Wrench held_now = within_limits(held);
  const Wrench before = held_now + shortened(within_limits(drivable(last)) - held_now, by_hand_n(last), tool.turning_radius_m);
  session = std::exchange(next, nullptr);
  tool = next_tool;
  begin_with_limit();
  shaper.impact.set_gain(session->scene().coupling().impact_ns_per_m);
  const Tick tick = session->tick(probe, dt_s);
  const Wrench step = within_limits(drivable(tick)) - before;
  shaper.release.shift(step);
  blend = blend - step;
  return tick;
}

TickFrame GuardedSession::State::tick(TickFrame frame, const Probe& probe) noexcept {
  if (std::exchange(begins, false)) {
    for (Session* one : {session, next})
      if (one) one->reset();
    shaper.reset();
    blend = {};
  }
  frame.result = exchanged(probe, frame.dt_s);
  frame.buttons = probe.buttons;
  frame.command = command_for(frame, probe.valid && frame.result.status != TickStatus::bad_input);
  held = {frame.result.force_n, frame.result.torque_nm};
  held_command = {frame.command.force_n, frame.command.torque_nm};
  return frame;
}

// Work of the last tick's command and of what was held without being sent.
Command GuardedSession::State::work_of(const TickFrame& frame) const noexcept {
  const Vec3& step_m = frame.result.probe_step_m;
  const Vec3 turn_rad = hand_turn_rad(frame);
  Command command{.work_on_hand_j = dot(held_command.force_n, step_m),
                  .withheld_j = dot(held.force_n - held_command.force_n, step_m)};
  if (turn_rad == Vec3{}) return command;
  const double withheld_turning_j = dot(held.torque_nm - held_command.torque_nm, turn_rad);
  command.work_on_hand_j += dot(held_command.torque_nm, turn_rad);
  command.withheld_j += withheld_turning_j;
  if (!drives_torque()) command.unfelt_j = -withheld_turning_j;
  return command;
}

// Filters between the limits and the guard.
Wrench GuardedSession::State::shaped(const TickFrame& frame, const Wrench& passed, double& snap_n) noexcept {
  const Tick& felt = frame.result;
  // The returned part of a withheld force grows gradually, and is no fall either.
  const double by_hand = by_hand_n(felt) + felt.given_back_n;
  const bool is_released = std::ranges::any_of(
      session->events(), [](const SessionEvent& event) { return event.kind == SessionEventKind::break_through; });
  const Wrench falling =
      shaper.release.shape(passed, is_released, by_hand, frame.dt_s, felt.energy.released_j > 0.0, tool.turning_radius_m);
  snap_n = shaper.release.snap_n();
  const GuardOptions& options = guard.options();
  const double fade_n = options.max_force_n * frame.dt_s / options.ramp_s;
  const double rest_n = size_n(blend, tool.turning_radius_m);
  blend = rest_n > fade_n ? (1.0 - fade_n / rest_n) * blend : Wrench{};
  shaper.impact.move(felt.probe_step_m, felt.probe_turn_step_rad, frame.dt_s);
  hit(shaper.impact, *session);
  Wrench wanted = shaper.impact.shape(falling);
  if (rest_n > 0.0) wanted = wanted + blend;
  return wanted;
}

Command GuardedSession::State::command_for(const TickFrame& frame, bool usable) noexcept {
  const Tick& felt = frame.result;
  const Guard::Passed passed = guard.pass(felt.force_n, felt.torque_nm);
  Command command = work_of(frame);
  command.guard = passed.state;
  command.cause = passed.cause;
  Wrench wanted{felt.force_n, felt.torque_nm};  // unchanged if not finite: the guard reports that
  if (usable && passed.state != GuardState::fault) {
    wanted = shaped(frame, {passed.command_n, passed.command_nm}, command.snap_n);
  } else {
    shaper.reset();
    blend = {};
  }
  if (!guard.options().motors) {
    if (!usable || passed.state == GuardState::fault) return command;
    const Wrench sent = within_limits(wanted);
    command.force_n = sent.force_n;
    command.torque_nm = sent.torque_nm;
    return command;
  }
  const Guard::Passed sent = guard.tick({.force_n = wanted.force_n,
                                         .probe_step_m = felt.probe_step_m,
                                         .time_step_s = frame.dt_s,
                                         .usable = usable,
                                         .buttons = frame.buttons,
                                         .circumstances = frame.circumstances,
                                         .gained_j = felt.energy.sampling_j + felt.energy.damper_j + command.unfelt_j,
                                         .torque_nm = wanted.torque_nm,
                                         .probe_turn_step_rad = hand_turn_rad(frame),
                                         .turning_radius_m = tool.turning_radius_m,
                                         .reach_m = tool.reach_m});
  command.force_n = sent.command_n;
  command.torque_nm = sent.command_nm;
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
void GuardedSession::switch_to(Session& next, const Tool& tool) noexcept {
  state_->next = &next;
  state_->next_tool = ToolSize(tool);
}
bool GuardedSession::brakes() const noexcept { return state_->brakes; }
const Session& GuardedSession::session() const noexcept { return *state_->session; }

}  // namespace palpa
