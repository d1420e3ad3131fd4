#include "palpa/study/felt.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/study/summary.h"

namespace palpa {
namespace {

/// Least share [1] of a step that a mode's change of force must have to explain it. Less: causes by chance; more: unknown ones.
constexpr double explaining_share = 0.5;

bool is_step(const FeltTick& before, const FeltTick& now) noexcept { return before.usable && now.usable; }

double step_n_per_ms(const FeltTick& before, const FeltTick& now) noexcept {
  return norm(now.command_n - before.command_n) / (1e3 * now.dt_s);
}

/// Mode of the largest change of force, if that explains a step.
int most_changed_mode(const FeltRun& run, std::size_t tick, double excess_n) noexcept {
  int found = -1;
  double most_n = explaining_share * excess_n;
  for (std::size_t m = 0; m < run.modes.size(); ++m) {
    const double change_n = norm(run.modes[m].force_n[tick] - run.modes[m].force_n[tick - 1]);
    if (change_n > most_n) {
      most_n = change_n;
      found = static_cast<int>(m);
    }
  }
  return found;
}

StepCause cause_by_mode(const FeltMode& mode, std::size_t tick) noexcept {
  if (mode.is_directed) return StepCause::directed;
  const double before_n = norm(mode.force_n[tick - 1]), now_n = norm(mode.force_n[tick]);
  if ((before_n > contact_force_n) != (now_n > contact_force_n)) return StepCause::release;
  const bool grew = std::abs(now_n - before_n) >= explaining_share * norm(mode.force_n[tick] - mode.force_n[tick - 1]);
  return grew ? StepCause::strength : StepCause::turn;
}

}  // namespace

bool places_directed_forces(std::string_view mode_type) noexcept {
  return mode_type == GradientForce::type || mode_type == VectorForce::type || mode_type == VortexForce::type;
}

bool drives(std::string_view mode_type) noexcept { return places_directed_forces(mode_type) || mode_type == VortexLine::type; }

FeltRun felt_run(const Scene& scene) {
  FeltRun run{.stiffness_n_per_m = scene.coupling().stiffness_n_per_m};
  for (const SceneMode& mode : scene.modes())
    run.modes.push_back({.name = mode.name, .is_directed = places_directed_forces(mode.mode.type())});
  return run;
}

FeltTick felt_tick(const TickFrame& frame) noexcept {
  const Tick& result = frame.result;
  return {.t_s = frame.t_s,
          .dt_s = frame.dt_s,
          .probe_m = result.probe_m,
          .proxy_m = result.proxy_m,
          .command_n = frame.command.force_n,
          .force_n = result.force_n,
          .torque_nm = result.torque_nm,
          .usable = result.probe_valid && is_finite(result.probe_m) && result.status != TickStatus::bad_input,
          .limited = frame.command.guard == GuardState::limited};
}

void add_tick(FeltRun& run, const TickFrame& frame, const Session& session) {
  FeltTick tick = felt_tick(frame);
  tick.other_event = frame.command.snap_n > 0.0;
  for (const SessionEvent& event : session.events()) {
    const bool broke = event.kind == SessionEventKind::break_through;
    tick.onset |= event.kind == SessionEventKind::onset;
    tick.broke_through |= broke;
    tick.other_event |= event.kind == SessionEventKind::fault || event.kind == SessionEventKind::warning;
    if (broke) tick.broke_force_n = std::max(tick.broke_force_n, run.stiffness_n_per_m * event.depth_m);
  }
  run.ticks.push_back(tick);
  const std::span<const ModeForce> modes = session.modes();
  for (std::size_t m = 0; m < run.modes.size(); ++m) run.modes[m].force_n.push_back(modes[m].force_n);
}

namespace {

FeltSignals signals_where(const FeltRun& run, const std::vector<bool>& counts) {
  FeltSignals signals;
  bool goes_on = false;
  for (std::size_t i = 0; i < run.ticks.size(); ++i) {
    if (counts[i] && !goes_on) {
      signals.command_n.emplace_back();
      signals.spring_n.emplace_back();
    }
    goes_on = counts[i];
    if (!goes_on) continue;
    signals.command_n.back().push_back(run.ticks[i].command_n);
    signals.spring_n.back().push_back(run.stiffness_n_per_m * run.ticks[i].probe_m);
  }
  return signals;
}

std::vector<bool> usable_between(const FeltRun& run, double from_s, double to_s) {
  std::vector<bool> counts;
  for (const FeltTick& tick : run.ticks) counts.push_back(tick.usable && tick.t_s >= from_s && tick.t_s < to_s);
  return counts;
}

}  // namespace

FeltSignals signals_of(const FeltRun& run, double from_s, double to_s) {
  return signals_where(run, usable_between(run, from_s, to_s));
}

FeltSignals quiet_signals_of(const FeltRun& run, double from_s, double to_s) {
  std::vector<bool> counts = usable_between(run, from_s, to_s);
  for (std::size_t i = 0; i < run.ticks.size(); ++i) {
    const FeltTick& tick = run.ticks[i];
    if (norm(tick.command_n) <= contact_force_n) counts[i] = false;
    if (!tick.onset && !tick.broke_through && !tick.other_event) continue;
    for (std::size_t j = i; tick.t_s - run.ticks[j].t_s <= after_break_through_s; --j) {
      counts[j] = false;
      if (j == 0) break;
    }
    for (std::size_t j = i; j < run.ticks.size() && run.ticks[j].t_s - tick.t_s <= after_break_through_s; ++j)
      counts[j] = false;
  }
  return signals_where(run, counts);
}

EdgesOfData::EdgesOfData(const Scene& scene) : hand_to_world_(scene.hand_to_world()) {
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) fields_.push_back(field.field);
  }
}

namespace {
bool has_data_at(const Field& field, const Vec3& world_m) noexcept {
  return field.components() == 1 ? field.scalar(world_m).inside : field.vector(world_m).inside;
}
}  // namespace

bool EdgesOfData::is_near(const Vec3& hand_m) const noexcept {
  const Vec3 world_m = hand_to_world_.to_world(hand_m);
  for (const FieldPtr& field : fields_) {
    const double away_m = field->local_spacing_m(world_m);
    const bool here = has_data_at(*field, world_m);
    for (const Vec3& way : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      if (has_data_at(*field, world_m + away_m * way) != here || has_data_at(*field, world_m - away_m * way) != here)
        return true;
    }
  }
  return false;
}

bool EdgesOfData::has_data(const Vec3& hand_m) const noexcept {
  const Vec3 world_m = hand_to_world_.to_world(hand_m);
  return std::all_of(fields_.begin(), fields_.end(), [&](const FieldPtr& field) { return has_data_at(*field, world_m); });
}

const char* name_of(StepCause cause) noexcept {
  switch (cause) {
    case StepCause::break_through: return "break-through";
    case StepCause::onset: return "onset";
    case StepCause::other_event: return "other event";
    case StepCause::edge: return "edge of data";
    case StepCause::directed: return "directed force";
    case StepCause::release: return "release";
    case StepCause::strength: return "strength";
    case StepCause::turn: return "turn";
    case StepCause::unknown: break;
  }
  return "unknown";
}

bool has_event(StepCause cause) noexcept {
  return cause == StepCause::break_through || cause == StepCause::onset || cause == StepCause::other_event;
}

std::vector<ExcessStep> excess_steps(const FeltRun& run, const EdgesOfData* edges, double above_n) {
  std::vector<ExcessStep> steps;
  double broke_s = -INFINITY, event_s = -INFINITY;
  for (std::size_t i = 0; i < run.ticks.size(); ++i) {
    const FeltTick& now = run.ticks[i];
    if (now.broke_through) broke_s = now.t_s;
    if (now.other_event) event_s = now.t_s;
    if (i == 0 || !is_step(run.ticks[i - 1], now)) continue;
    const FeltTick& before = run.ticks[i - 1];
    ExcessStep step{.tick = i, .t_s = now.t_s, .step_n = norm(now.command_n - before.command_n)};
    step.excess_n = step.step_n - run.stiffness_n_per_m * distance(now.probe_m, before.probe_m);
    if (!(step.excess_n > above_n)) continue;
    step.mode = most_changed_mode(run, i, step.excess_n);
    if (now.t_s - broke_s <= after_break_through_s) {
      step.cause = StepCause::break_through;
    } else if (now.onset || before.onset) {
      step.cause = StepCause::onset;
    } else if (now.t_s - event_s <= after_break_through_s) {
      step.cause = StepCause::other_event;
    } else if (edges && (edges->is_near(now.proxy_m) || edges->is_near(before.proxy_m))) {
      step.cause = StepCause::edge;
    } else if (step.mode >= 0) {
      step.cause = cause_by_mode(run.modes[static_cast<std::size_t>(step.mode)], i);
    }
    steps.push_back(step);
  }
  return steps;
}

double steepest_fall_n_per_ms(const FeltRun& run) noexcept {
  double steepest = 0.0, broke_s = -INFINITY;
  for (std::size_t i = 1; i < run.ticks.size(); ++i) {
    const FeltTick &before = run.ticks[i - 1], &now = run.ticks[i];
    if (now.broke_through) broke_s = now.t_s;
    if (is_step(before, now) && now.t_s - broke_s <= after_break_through_s)
      steepest = std::max(steepest, step_n_per_ms(before, now));
  }
  return steepest;
}

double steepest_at_edges_n_per_ms(const FeltRun& run, const EdgesOfData& edges) noexcept {
  double steepest = 0.0, level_s = -INFINITY;
  for (std::size_t i = 1; i < run.ticks.size(); ++i) {
    const FeltTick &before = run.ticks[i - 1], &now = run.ticks[i];
    if (now.broke_through || now.onset) level_s = now.t_s;
    if (!is_step(before, now) || now.t_s - level_s <= after_break_through_s) continue;
    const double steep = step_n_per_ms(before, now);
    // `is_near` is last because it is slow: it samples every field at seven places.
    if (steep > steepest && (edges.is_near(now.proxy_m) || edges.is_near(before.proxy_m))) steepest = steep;
  }
  return steepest;
}

double saturated_share(const FeltRun& run) noexcept {
  const auto limited = std::count_if(run.ticks.begin(), run.ticks.end(), [](const FeltTick& tick) { return tick.limited; });
  return run.ticks.empty() ? 0.0 : static_cast<double>(limited) / static_cast<double>(run.ticks.size());
}

double duration_s(const FeltRun& run) noexcept {
  double sum_s = 0.0;
  for (const FeltTick& tick : run.ticks) sum_s += tick.dt_s;
  return sum_s;
}

}  // namespace palpa
