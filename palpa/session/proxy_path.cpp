#include "palpa/session/proxy_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/session/path_tolerances.h"

namespace palpa {

using namespace path_tolerances;

namespace {

constexpr int max_moves = 128;  // [1] per tick. More: longer worst tick; fewer: the proxy lags behind the hand
// A move of many feet that the work cut short would be cut short again: it has at least so many trials, and begins with as
// much work as they take. More: longer worst tick; less: a pad is left behind for ever.
constexpr int tool_trials = 3;                         // [1]
constexpr int tool_spared_work = tick_work::most / 4;  // [units]
// [1] Sub-steps after which the rest of a tool that creeps is left to the next tick. More: longer worst tick; fewer: it lags.
constexpr std::size_t most_creeping = 8;
constexpr double directed_n_per_s = 100.0;  // [N/s] allowed while data play. Less: forces lag the data; more: they jump

}  // namespace

ProxyPath::ProxyPath(StateArena& live, const Scene& scene, const Similarity& map, std::unique_ptr<Law> law, Steps steps)
    : stiffness_n_per_m_(scene.coupling().stiffness_n_per_m),
      tool_(scene.tool(), scene.coupling()),
      contacts_(live, scene.modes().size(), tool_.feet(), ContactProblem::most_primitives(tool_.feet())),
      modes_(live, scene, map, tool_, contacts_),
      crossings_(live, modes_.watches(), modes_.fields(), tool_.feet()),
      policy_(crossings_.policy()),
      moments_(live, scene.time(), modes_, tool_),
      model_(live, std::move(law), modes_, scene.coupling().stiffness_n_per_m, work_),
      state_(live.add<PathState>()),
      stopped_by_(live.add<Crossing>(tool_.feet())),
      queue_(live.add<ProbeQueue>()),
      steps_(steps),
      goes_with_probe_(tool_.is_point() && !modes_.any_enabled() && !moments_.can_change()),
      step_share_(steps == Steps::refined ? 0.5 : unbounded) {
  events_.reserve(tool_.feet());
  while (events_.size() < tool_.feet()) events_.push_back(crossings_.event());
  entered_.reserve(tool_.feet() * modes_.size());
  if (!tool_.is_point()) {
    patient_trials_ = tool_trials;
    spared_work_ = tool_spared_work;
  }
  modes_.set_time(moments_.now());
  refine(1);
  reset();
}

void ProxyPath::reset() noexcept {
  state_ = PathState{.proxy = state_.proxy};
  moments_.reset();
  std::ranges::fill(stopped_by_, Crossing{});
  queue_.start({});
  model_.clear();
  crossings_.reset();
  modes_.start();
  contacts_.clear();
  record_.clear();
}

void ProxyPath::refine(int times) {
  refined_ = std::clamp(times, 1, 16);
  record_.reserve(static_cast<std::size_t>(Session::max_sub_steps * refined_), tool_.feet());
}

void ProxyPath::after_state_copy(const ProxyPath& other) noexcept {
  model_.forget_warm_start();
  moments_.take_windows_of(other.moments_);
  modes_.set_time(moments_.view());
}

void ProxyPath::start_at_proxy_of(const ProxyPath& other) noexcept {
  state_ = other.state_;
  reset();
  moments_.resume(other.moments_);
  state_.started = other.state_.started;
  queue_.start(other.queue_.processed_up_to());
  state_.followed = other.state_.followed;
  modes_.set_time(moments_.view());
}

void ProxyPath::start(const Pose& probe, double time_step_s) noexcept {
  PathState& c = state_;
  c.started = true;
  c.proxy = c.followed = probe;
  queue_.start(probe);
  moments_.start(c.proxy, path_m_, time_step_s);
  modes_.set_time(moments_.view());
}

WindowNeed ProxyPath::window_need(const Pose& probe, bool valid, double time_step_s) noexcept {
  const Pose at{probe.position_m, tool_.is_point() ? Turn{} : unit_turn(probe.turn)};
  const bool follows = state_.started && valid && is_finite(at.position_m);
  const double way_m = follows ? tool_.way_m(queue_.last(), at) : 0.0;
  const Pose& start = state_.started ? state_.proxy : at;
  return moments_.need(start, follows ? at : start, way_m, time_step_s);
}

const Walk& ProxyPath::walk(const Pose& probe, double time_step_s) noexcept {
  record_.clear();
  contacts_.begin_tick();
  work_.refill(refined_);
  const PathState& c = state_;
  walk_.from = c.proxy;
  walk_.released_m = {};
  walk_.is_complete = true;
  walk_.unreached_m = 0.0;
  walk_.dropped = 0;
  path_m_ = queue_.push(probe, time_step_s, tool_);
  if (goes_with_probe_ && refined_ == 1) {
    go_with_probe();
    return walk_;
  }
  moments_.choose_octave(c.proxy, path_m_, time_step_s);
  if (moments_.can_change()) find_changes();
  const double data_way_m = changes_ ? modes_.motion_m(c.proxy, moments_.followed(), moments_.now()) : 0.0;
  const bool is_limited = c.is_held_back || (changes_ && moments_.octaves_fade());
  allowed_m_ = is_limited ? DataMoments::fading_way_m(path_m_, data_way_m, time_step_s, stiffness_n_per_m_) : unbounded;
  path_m_ = std::max(path_m_, data_way_m);

  ProbeSegment& segment = segment_;
  for (int moves = 0; walk_.is_complete && next_segment(segment); ++moves) {
    const auto steps = static_cast<int>(record_.sub_steps().size());
    const bool may_go_on = steps < Session::max_sub_steps * refined_ && moves < max_moves * refined_ &&
                           work_.left() > spared_work_ && moments_.reach_m(c.proxy) > 0.0;
    if (may_go_on) {
      steps_ == Steps::refined ? sub_step(segment) : one_step(segment);
    } else if (may_give_up()) {
      give_up();
    } else {
      walk_.is_complete = false;
      record_.cut();
    }
  }
  walk_.is_complete = walk_.is_complete && work_.any();  // else the last move was cut short
  walk_.proxy = c.proxy;
  walk_.followed = c.followed;
  walk_.work = work_.spent();
  return walk_;
}

// Without an enabled mode there is no primitive, and no event. The balance is at the probe, so that nothing is stretched or
// released.
void ProxyPath::go_with_probe() noexcept {
  const ProbeSegment segment = queue_.front();  // the whole path: none is ever left
  const StepContext context{state_.proxy, segment.to, segment.time_s, stiffness_n_per_m_, 1.0};
  work_.spend(modes_.work() + 1);
  state_.proxy = model_.pose_of(model_.balance_of_nothing(context), segment.to);
  queue_.pop(segment, tool_);
  state_.followed = queue_.processed_up_to();
  moments_.follow();
  static constexpr Move whole;
  log(segment, whole, context, false);
  walk_.proxy = state_.proxy;
  walk_.followed = state_.followed;
  walk_.work = work_.spent();
}

// Whether the data change in this tick. Data that stand still are as plain ones.
void ProxyPath::find_changes() noexcept {
  const DataTime now = moments_.now();
  changes_ = moments_.followed() != now || moments_.view() != now || modes_.any_fades();
  if (changes_) return;
  moments_.stand_still();
  modes_.set_time(now);
  moved_n_ = 0.0;
}

// Next segment of the probe's path, short enough not to skip data. Stays queued until it is walked.
bool ProxyPath::next_segment(ProbeSegment& segment) noexcept {
  const PathState& c = state_;
  if (c.pending != Pending::nothing) {
    segment = {queue_.processed_up_to(), queue_.processed_up_to(), c.left_s, false};
    return true;
  }
  if (queue_.empty()) return false;
  segment = queue_.front();
  const double length = tool_.way_m(segment.from, segment.to);
  const double furthest =
      changes_ ? std::max(length, modes_.motion_m(c.proxy, moments_.followed(), moments_.at(time_at_end_of(segment)))) : length;
  if (refined_ == 1 && furthest <= step_share_ * modes_.finest_m()) return true;
  double longest = step_share_ / refined_ * modes_.finest_m(c.proxy, segment.from, segment.to);
  if (refined_ > 1) longest = std::min(longest, path_m_ / refined_);
  const bool is_long = furthest > (1.0 + contact_tolerance) * longest && !(tool_.are_one(c.proxy, segment.from) && is_free());
  if (is_long) segment = segment.first(longest / furthest, tool_);
  return true;
}

// Free flight: all forces are zero, and every onset is watched. Never after a move in which something could pull.
bool ProxyPath::is_free() noexcept {
  if (state_.felt) return false;
  work_.spend(modes_.work());
  const Pose& here = state_.proxy;
  return modes_.is_free_at({here, here, 1.0, stiffness_n_per_m_, modes_.finest_m()}, entered_);
}

// Samples the data at the segment's end time from here on. Returns their advance.
DataMoments::Step ProxyPath::advance_data(const ProbeSegment& segment) noexcept {
  work_.spend(modes_.work());
  const DataTime followed = moments_.followed();
  const DataMoments::Step step = moments_.advance_view(segment.fresh ? time_at_end_of(segment) : moments_.view_s());
  modes_.advance(state_.proxy, followed, moments_.view(), moments_.now(), step.passed_s, [&](std::size_t m) {
    contacts_.warn(m, "a level jumps between two frames instead of moving: its strength fades out and in");
  });
  moved_n_ = 0.5 * stiffness_n_per_m_ * modes_.furthest_carried_m() + directed_n_per_s * step.passed_s;
  return step;
}

void ProxyPath::sub_step(ProbeSegment& segment) noexcept {
  StepContext context{state_.proxy, segment.to, segment.time_s, stiffness_n_per_m_};
  const Pose& start = context.start;
  const bool settles = !segment.fresh && state_.pending == Pending::settling;
  const double finest_m = modes_.finest_m(start, start, segment.to);
  step_m_ = step_share_ / refined_ * finest_m;
  context.spacing_m = spacing_m_ = std::min(finest_m, 1.0);  // without data any length will do
  const DataMoments::Step follows = changes_ ? advance_data(segment) : DataMoments::Step{};
  if (!settles) modes_.begin_step(state_.step_start = start);
  const Move made = move(segment, context, settles);

  const Pose end = end_from(start, made);
  const double went_m = tool_.way_m(start, end);
  const double rest_m = rest * spacing_m_;
  // A settling move of at most `rest` is not made: the proxy rests.
  const bool rests = made.fraction == 0.0 || (made.stop == Stop::full && went_m <= rest_m);
  if (settles && rests && !model_.any_shut()) {
    state_.pending = Pending::nothing;
  } else {
    // While the hand moves, the next tick settles the rest; with a still hand, or once begun, settling is completed.
    const bool to_the_end = settles || path_m_ == 0.0;
    const bool is_settled = !model_.any_holds() ? made.change_m <= turned * spacing_m_
                            : to_the_end        ? went_m <= rest_m
                                                : model_.unsettled_m(end) <= turned * spacing_m_;
    // Near a balance that is about to tip over, a tool creeps towards the next.
    const bool creeps =
        !tool_.is_point() && settles && went_m <= turned * spacing_m_ && record_.sub_steps().size() >= most_creeping;
    // A level that gives way still took part in this balance.
    const bool lets_go = model_.any_gives_way(crossings_) && went_m > rest_m;
    advance(segment, made, end, follows, is_settled && !lets_go);
    allowed_m_ -= went_m;
    state_.is_held_back = !(allowed_m_ > bound_m);
    if (state_.is_held_back || (creeps && !lets_go)) leave_rest();
    accept(segment, made, context, settles);
    model_.end_move();
  }
  walk_.unreached_m = state_.is_held_back ? 0.0 : tool_.length_m(state_.proxy, made.to_pose);
  modes_.arrive();
}

// Step of earlier systems, straight to the balance. Events do not stop it; modes are notified afterwards.
void ProxyPath::one_step(const ProbeSegment& segment) noexcept {
  const Pose start = state_.proxy;
  const bool at_probe = steps_ == Steps::one_at_probe;
  spacing_m_ = std::min(modes_.finest_m(start, start, segment.to), 1.0);
  StepContext context{start, segment.to, segment.time_s, stiffness_n_per_m_, spacing_m_};
  const DataMoments::Step follows = changes_ ? advance_data(segment) : DataMoments::Step{};
  modes_.begin_step(state_.step_start = start);

  model_.begin_move(context, spacing_m_);
  const Pose& at = at_probe ? segment.to : start;
  model_.place(context, at, at, at_probe ? 1.0 : 0.0, unbounded);
  Move made;
  balance(made, context.probe, context.time_step_s);
  // No crossing stops the step. But a level whose plane holds a foot stays held: on a round surface a step along that plane
  // ends off the level, which is no release.
  using CrossingRule = EventPolicy::CrossingRule;
  for (std::size_t foot = 0; foot < tool_.feet(); ++foot) {
    configure_events(foot, start, false);
    std::ranges::replace_if(
        policy_.passing, [](CrossingRule passing) { return passing != CrossingRule::held; }, CrossingRule::passes);
    crossings_.first_event(foot, tool_.foot_m(start, foot), tool_.foot_m(made.to_pose, foot), policy_, modes_.samples(foot),
                           work_, events_[foot]);
  }

  advance(segment, made, made.to_pose, follows, true);
  accept(segment, made, context, false);
  modes_.arrive();
}

void ProxyPath::log(const ProbeSegment& segment, const Move& made, const StepContext& context, bool settles) noexcept {
  SubStep& step = record_.begin();
  step.time_step_s = segment.time_s;
  step.start_m = context.start.position_m;
  step.probe_m = segment.to.position_m;
  step.stiffness_n_per_m = stiffness_n_per_m_;
  step.balance = model_.last_balance();
  step.move_fraction = made.fraction;
  step.stop = made.stop;
  step.proxy_m = state_.proxy.position_m;
  if (!tool_.is_point()) {
    step.start_turn = context.start.turn, step.probe_turn = segment.to.turn, step.proxy_turn = state_.proxy.turn;
    step.turning_radius_m = tool_.turning_radius_m();
  }
  record_.end(settles, context.spacing_m, model_, modes_);
}

void ProxyPath::accept(const ProbeSegment& segment, const Move& made, const StepContext& context, bool settles) noexcept {
  log(segment, made, context, settles);
  walk_.dropped += model_.set().dropped();
  state_.felt = model_.set().can_pull();
  if (made.fraction > 0.0 || made.stop == Stop::event) {  // also where a foot stands on one already
    for (std::size_t foot = 0; foot < tool_.feet(); ++foot) crossings_.apply(foot, events_[foot]);
  }
  const bool is_stopped = made.stop == Stop::event && !first_event().crossings.empty();
  // Of a point the crossing of the last move; of a tool those of all feet since it last got on.
  if (tool_.is_point() || tool_.way_m(state_.move_m) > rest * spacing_m_) std::ranges::fill(stopped_by_, Crossing{});
  if (is_stopped) stopped_by_[first_foot_] = first_event().crossings.back();
  const Balance& to = model_.last_balance();
  contacts_.update(model_, state_.proxy, to, distance(to.position_m, segment.to.position_m), crossings_);
  modes_.on_step_accepted(context, state_.proxy, made.fraction, model_.set(), events_);
}

// Moves the proxy. The pending rest of the segment continues where the move was stopped.
void ProxyPath::advance(const ProbeSegment& segment, const Move& move, const Pose& end, const DataMoments::Step& follows,
                        bool settled) noexcept {
  PathState& c = state_;
  const Pose start = std::exchange(c.proxy, end);
  const Motion before_m = std::exchange(c.move_m, tool_.motion(start, end));
  // Where directions turn faster than the spring can follow, or a level bends more than its length, the proxy turns back: each
  // turn halves the longest move. After eight (max_sub_steps / 4) the probe position may be given up, which bounds the lag.
  const double settling_m2 = model_.has_directions() ? 0.0 : 0.25 * tool_.product_m2(before_m, before_m);
  const bool turns_back =
      !segment.fresh && tool_.product_m2(c.move_m, before_m) < 0.0 && tool_.product_m2(c.move_m, c.move_m) > settling_m2;
  extrapolate_moves(before_m, segment.fresh);
  c.max_move_m = turns_back      ? std::min(c.max_move_m, 0.5 * tool_.way_m(before_m))
                 : may_give_up() ? c.max_move_m
                                 : 1.25 * c.max_move_m;
  const bool has_no_end =
      move.stop == Stop::release && segment.time_s <= contact_tolerance * c.whole_s;  // round a vortex: its time is over
  c.turns = segment.fresh ? 0 : c.turns + (turns_back || has_no_end);
  if (segment.fresh) c.segment_start = start, c.probe_way_m = tool_.motion(segment.from, segment.to);
  // The part of the proxy's motion beyond that of probe and data is a release.
  const double moved_m =
      (segment.fresh ? tool_.length_m(segment.from, segment.to) : 0.0) + move.fraction * modes_.furthest_carried_m();
  const double went_m = tool_.is_point() ? norm(c.move_m.way_m) : length(c.move_m);
  if (went_m > moved_m) walk_.released_m += (1.0 - moved_m / went_m) * c.move_m;
  if (segment.fresh) {
    c.whole_s = segment.time_s;
    queue_.pop(segment, tool_);
  }
  c.pending = pending_after(move, settled);
  if (work_.any() && c.pending != Pending::path) c.followed = queue_.processed_up_to();
  moments_.follow(follows, c.pending != Pending::nothing ? 1.0 - move.fraction : 0.0);
  c.left_s = c.pending == Pending::settling ? segment.time_s
                                            : std::max(contact_tolerance * c.whole_s, (1.0 - move.fraction) * segment.time_s);
}

// Whether the proxy has turned back so often that the probe position may be given up without a balance.
bool ProxyPath::may_give_up() const noexcept { return 4 * state_.turns >= Session::max_sub_steps * refined_; }

// Gives the probe position up: the proxy stays.
void ProxyPath::give_up() noexcept {
  leave_rest();
  state_.turns = 0;
}

// Leaves the rest of the way to the balance to the next probe position.
void ProxyPath::leave_rest() noexcept {
  state_.pending = Pending::nothing;
  state_.followed = queue_.processed_up_to();
  moments_.follow();
}

ProxyPath::Pending ProxyPath::pending_after(const Move& move, bool settled) const noexcept {
  const PathState& c = state_;
  // A tick's last position is given up later, nearer to a balance, as moves are left.
  if (may_give_up() && (!queue_.empty() || 2 * c.turns >= Session::max_sub_steps * refined_)) return Pending::nothing;
  const bool is_whole = move.stop == Stop::full || (move.bound_met && move.stop == Stop::event && move.fraction == 1.0);
  if (is_whole) return !model_.set().empty() && !settled ? Pending::settling : Pending::nothing;
  const bool crosses = move.stop == Stop::event && !first_event().crossings.empty();  // else nothing changes on the spot
  const bool gets_on =
      (move.fraction > 0.0 || crosses) && (move.stop != Stop::release || tool_.way_m(c.move_m) > rest * spacing_m_);
  if (!gets_on) return Pending::nothing;
  return move.stop == Stop::energy && !changes_ ? Pending::settling : Pending::path;
}

}  // namespace palpa
