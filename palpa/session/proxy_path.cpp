#include "palpa/session/proxy_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/session/path_tolerances.h"

namespace palpa {

using namespace path_tolerances;

namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();
constexpr int max_moves = 128;    // [1] per tick. More: longer worst tick; fewer: the proxy lags behind the hand
constexpr int max_trials = 24;    // [1] balances per move. More: longer worst tick; fewer: moves are given up
constexpr int max_shutting = 8;   // [1] more of them, if a level has to be shut. Fewer: the proxy is given up on its path
constexpr double bound_m = 1e-8;  // [m] stop before a break-through. Less: decided by rounding; more: breaks early
// A move of many feet that the work cut short would be cut short again: it has at least so many trials, and begins with as
// much work as they take. More: longer worst tick; less: a pad is left behind for ever.
constexpr int tool_trials = 3;                         // [1]
constexpr int tool_spared_work = tick_work::most / 4;  // [units]
// [1] Sub-steps after which the rest of a tool that creeps is left to the next tick. More: longer worst tick; fewer: it lags.
constexpr std::size_t most_creeping = 8;
constexpr int most_chords = 3;  // [1] searched for the first event of a turning tool. More: work; fewer: it stops beside it
constexpr double most_turn_rad = 0.3;       // [rad] of a move. More: levers change too much for one balance; less: more moves
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

// Lets the modes place primitives for a move on the way to `whole_end`, expected to end at `end`.
void ProxyPath::place(const StepContext& context, const Pose& end, const Pose& whole_end) noexcept {
  double data_fraction = 0.0;
  if (modes_.furthest_carried_m() > 0.0) {
    const double whole_m = tool_.way_m(context.start, whole_end);
    data_fraction = whole_m > 0.0 ? 0.5 * std::min(1.0, tool_.way_m(context.start, end) / whole_m) : 0.0;
  }
  const std::int32_t held_back =
      model_.place(context, tool_.middle(state_.step_start, end), context.start, data_fraction, moved_n_);
  if (held_back >= 0) contacts_.warn_held_back(static_cast<std::size_t>(held_back));
  if (!tool_.are_one(end, context.start)) model_.predict_planes(end);
}

void ProxyPath::balance(Move& move, const Pose& probe, double time_step_s) noexcept {
  move.to_pose = model_.pose_of(model_.balance(probe, time_step_s), probe);
}

// Share [1] of a motion up to a turn on which no foot leaves its chord by more than `piercing`.
double ProxyPath::share_of_turn(const Motion& motion) const noexcept {
  if (motion.arc_m == Vec3{}) return 1.0;
  const double turn_rad = norm(motion.arc_m) / tool_.turning_radius_m();
  const double most_rad = std::min(most_turn_rad, std::sqrt(8.0 * piercing * spacing_m_ / tool_.reach_m()));
  return most_rad / turn_rad;
}

// Of a tool a flight whose search fits several times into the work of a move: a longer one, cut short at its first event and
// searched again, would end where it began, for ever.
double ProxyPath::longest_flight_m() noexcept {
  if (tool_.is_point()) return unbounded;
  int piece_work = 0;
  for (std::size_t field = 0; field < modes_.fields(); ++field)
    piece_work += modes_.samples(0).work_of_look(static_cast<std::int32_t>(field));
  const double all_feet_work = static_cast<double>(tool_.feet()) * std::max(1, piece_work);
  return spacing_m_ * std::max(1.0, tool_spared_work / (most_chords * all_feet_work));
}

// Move without primitives, no longer than `longest_m`: no level gives way, and every end is free.
ProxyPath::Move ProxyPath::move_freely(const StepContext& context, bool flies, double longest_m) noexcept {
  Move made;
  balance(made, context.probe, context.time_step_s);
  const Motion whole = tool_.motion(context.start, made.to_pose);
  made.fraction = share_of(whole, tool_.way_m(whole), longest_m);
  made.stop = made.fraction == 1.0 ? Stop::full : Stop::release;
  stop_at_first_event(context.start, flies, made);
  return made;
}

// One move towards the balance, at most half a sample spacing, to the first free position. If the end is not free, the facets
// that exclude it are added and the balance is repeated. Directions are sampled at the middle of the move: sampled at its start
// they would lead the proxy off the outside of every curve.
ProxyPath::Move ProxyPath::move(ProbeSegment& segment, StepContext& context, bool settles) noexcept {
  const Pose& start = context.start;
  if (segment.fresh) state_.max_move_m = unbounded;
  double longest = std::min(step_m_, state_.max_move_m);
  const bool flies = tool_.way_m(start, segment.to) > longest && is_free();
  if (flies) longest = longest_flight_m();
  longest =
      std::min({longest, flies ? moments_.reach_m(start, segment.to) : moments_.reach_m(start), std::max(bound_m, allowed_m_)});
  const auto shorten = [&](Pose& end, const Motion& motion, double share) {
    if (share < 1.0) end = tool_.moved(start, share * motion);
  };

  Move made;
  bool rests = false;
  double change_before_m = unbounded;
  Pose end = tool_.moved(start, expected_m(segment));
  const Motion expected = tool_.motion(start, end);
  shorten(end, expected, share_of(expected, tool_.way_m(expected), longest));
  const double same_m = (settles ? piercing : turned) * spacing_m_;  // settling moves are a small part of a step
  model_.begin_move(context, spacing_m_);
  place(context, end, end);
  if (model_.set().empty() && !settles) return move_freely(context, flies, longest);
  for (int trial = 0; trial < max_trials + max_shutting && (trial < patient_trials_ || work_.any()); ++trial) {
    balance(made, context.probe, context.time_step_s);
    // No level may give way because of a predicted plane.
    if (model_.any_gives_way(crossings_) && model_.revert_prediction()) balance(made, context.probe, context.time_step_s);
    made.bound_met = made.bound_met || (trial == 0 && segment.fresh && locate_break_through(segment, context, made));
    context.probe = segment.to;
    context.time_step_s = segment.time_s;
    const Motion whole = tool_.motion(start, made.to_pose);
    const double length = tool_.way_m(whole);
    const double share = share_of(whole, length, longest);
    const Pose before = std::exchange(end, made.to_pose);
    shorten(end, whole, share);
    made.change_m = model_.has_directions() ? tool_.way_m(before, end) : 0.0;
    // Place again as long as the end changes, and by less each time.
    if (made.change_m > same_m && made.change_m < change_before_m && trial + 1 < max_trials && !made.bound_met &&
        (!tool_.are_one(before, start) || tool_.way_m(start, end) > same_m)) {
      change_before_m = made.change_m;
      place(context, end, made.to_pose);
      continue;
    }
    change_before_m = unbounded;
    rests = settles && std::min(length, state_.max_move_m) <= rest * spacing_m_;
    if (rests) break;
    made.fraction = share;
    made.stop = made.bound_met ? Stop::event : made.fraction == 1.0 ? Stop::full : settles ? Stop::energy : Stop::release;
    if (end_is_free(segment, context, flies, made)) return made;
    // A level that blocks without an explaining facet is shut: it bears its strength and no more. If the balance is nearer than
    // `shallow` the proxy rests instead.
    const bool is_blocked = !(made.fraction > 0.0) || trial + 1 >= max_trials;
    if (is_blocked && (length <= shallow * spacing_m_ || !model_.shut())) break;
  }
  if (!rests) balance(made, context.probe, context.time_step_s);  // with all facets added
  made.fraction = 0.0;
  made.stop = Stop::energy;
  return made;
}

// Whether the move may end where `move` ends, shortened to its first event. False if a facet was added (balance again), or,
// with a fraction of zero, if no nearer end is free.
bool ProxyPath::end_is_free(const ProbeSegment& segment, const StepContext& context, bool flies, Move& move) noexcept {
  const Pose& start = context.start;
  do {
    const Pose reached = stop_at_first_event(start, flies, move);
    const auto accepts = [&](double deepest) {
      return model_.accepts(reached, deepest, move.to_pose, move.fraction, segment.to, context.time_step_s);
    };
    if (accepts(still)) return true;
    const bool is_rejected = model_.repredict_once(reached) || model_.revert_prediction() || model_.add_cutting_planes(reached);
    if (!is_rejected && accepts(shallow)) return true;
    for (Event& event : events_) event.crossings.clear();
    if (is_rejected) return false;
    move.fraction *= 0.5;
    move.stop = Stop::energy;
  } while (tool_.way_m(start, end_from(start, move)) > rest * spacing_m_ && work_.any());
  move.fraction = 0.0;
  return false;
}

// Shortens the move to its first event. Returns its end. Events are searched on the chords of the feet; on a shorter arc a foot
// is not on its former chord, so that the shorter chord is searched again.
Pose ProxyPath::stop_at_first_event(const Pose& start, bool flies, Move& move) noexcept {
  Pose end = end_from(start, move);
  for (int search = 0; search < most_chords; ++search) {
    find_events(start, end, flies);
    if (first_event().kind == Event::Kind::none) break;
    // Events nearer to the move's end are left to the next sub-step.
    const double way_m = tool_.way_m(start, end) + modes_.furthest_carried_m();
    if (!((1.0 - first_event().share) * way_m > rest * spacing_m_)) break;
    const bool turns = end.turn != start.turn;
    move.fraction *= first_event().share;
    move.stop = Stop::event;
    end = end_from(start, move);
    // At the move's start, where a chord and its arc are one, another search would only lose the crossing.
    if (!turns || !(first_event().share * way_m > rest * spacing_m_)) break;
  }
  return end;
}

// Finds the first event of each foot in the move.
void ProxyPath::find_events(const Pose& start, const Pose& end, bool flies) noexcept {
  first_foot_ = 0;
  for (std::size_t foot = 0; foot < tool_.feet(); ++foot) {
    Event& event = events_[foot];
    if (!changes_ && entered_.empty() && !crossings_.any_watched() && model_.contacts().empty()) {  // nothing to meet
      event.clear();
      continue;
    }
    const Vec3 start_m = tool_.foot_m(start, foot), end_m = tool_.foot_m(end, foot);
    const auto search = [&] { crossings_.first_event(foot, start_m, end_m, policy_, modes_.samples(foot), work_, event); };
    configure_events(foot, end, flies);
    search();
    if (reverses_last_crossing(foot, start_m, end_m)) {
      for (const Crossing& crossing : event.crossings)
        crossings_.configure_events(policy_, {crossing.field, crossing.value}, EventPolicy::CrossingRule::passes);
      search();
    }
    if (event.share < first_event().share) first_foot_ = foot;
  }
}

// Where a value jumps, both sides may drive a foot across: an immediate reversal of the last crossing does not stop it again,
// or it would be caught between the two.
bool ProxyPath::reverses_last_crossing(std::size_t foot, const Vec3& start_m, const Vec3& end_m) const noexcept {
  const Event& event = events_[foot];
  if (event.kind != Event::Kind::crossing || event.share * distance(start_m, end_m) > rest * spacing_m_) return false;
  const Crossing& first = event.crossings.front();
  const Crossing& last = stopped_by_[foot];
  return first.field == last.field && first.value == last.value && first.up != last.up;
}

// Ends the segment where a shell that held gives way. Located on the probe's path by bisection; of a tool, whose balances cost
// more, by extrapolation from the side where it holds (beyond, the feet move on at once), with bisection on slow convergence.
bool ProxyPath::locate_break_through(ProbeSegment& segment, const StepContext& context, Move& move) noexcept {
  if (!model_.any_gives_way(crossings_)) return false;
  const double length = tool_.way_m(segment.from, segment.to);
  if (!(length > bound_m)) return false;
  const auto overload_at = [&](double share) {
    balance(move, segment.first(share, tool_).to, std::max(share, contact_tolerance) * context.time_step_s);
    return model_.overload(crossings_);
  };
  // Most levels that give way here do so from the start on: a single balance detects it.
  double held = std::min(1.0, 2.0 * bound_m / length), gone = 1.0;
  double over_held = overload_at(held), slope = 0.0;
  const bool holds_at_first = !(over_held > 0.0);
  for (bool halve = true; holds_at_first && (gone - held) * length > bound_m && work_.any();) {
    const double width = gone - held, root = held - over_held / slope;
    const double off = std::max(0.25 * bound_m / length, 0.01 * (root - held));  // to either side, so that both ends close in
    const double near_root = root + off < gone ? root + off : root - off;
    const double middle = !halve && near_root > held && near_root < gone ? near_root : 0.5 * (held + gone);
    const double over = overload_at(middle);
    if (over > 0.0) {
      gone = middle;
    } else {
      slope = (over - over_held) / (middle - held);
      held = middle, over_held = over;
    }
    halve = tool_.is_point() || !(slope > 0.0) || (!halve && over <= 0.0 && gone - held > 0.5 * width);
  }
  if (!holds_at_first || !work_.any()) {  // without work for the search: at the end of the segment
    balance(move, segment.to, context.time_step_s);
    return false;
  }
  held -= bound_m / length;  // there rounding of forces does not decide whether the level holds
  overload_at(gone);
  model_.stop_at_bound();
  segment = segment.first(held, tool_);
  balance(move, segment.to, segment.time_s);
  return true;
}

// Sums the remaining moves (Aitken). A proxy pressed d into an elastic level of curvature 1/R rests after moves that shrink by
// about d/R each, a tool pressed along a lever b by a force F after moves that shrink by Fb/κ; the ratio is taken from two
// moves without this sum.
void ProxyPath::extrapolate_moves(const Motion& before_m, bool fresh) noexcept {
  PathState& c = state_;
  c.moves_without_extrapolation = fresh || c.extrapolated_m == Motion{} ? c.moves_without_extrapolation + 1 : 0;
  const bool is_known =
      !fresh && c.moves_without_extrapolation >= 2 && (!tool_.is_point() || contacts_.any_pressed_in()) && before_m != Motion{};
  const double ratio =
      is_known ? std::clamp(tool_.product_m2(c.move_m, before_m) / tool_.product_m2(before_m, before_m), 0.0, 0.9) : 0.0;
  c.extrapolated_m = ratio / (1.0 - ratio) * c.move_m;
}

// Expected move: the last segment's, scaled by the probe's motion; when settling, the sum above.
Motion ProxyPath::expected_m(const ProbeSegment& segment) const noexcept {
  if (!segment.fresh) return state_.pending == Pending::settling ? state_.extrapolated_m : Motion{};
  const double before_m2 = tool_.product_m2(state_.probe_way_m, state_.probe_way_m);
  if (changes_ || !(before_m2 > 0.0)) return {};
  const double share = tool_.product_m2(tool_.motion(segment.from, segment.to), state_.probe_way_m) / before_m2;
  return std::clamp(share, 0.0, 1.0) * tool_.motion(state_.segment_start, state_.proxy);
}

void ProxyPath::configure_events(std::size_t foot, const Pose& end, bool flies) noexcept {
  policy_.clear();
  if (changes_) modes_.configure_events(foot, crossings_, policy_, tool_.foot_m(state_.proxy, foot));
  model_.configure_events(foot, crossings_, end, policy_);
  for (const std::int32_t field : entered_) policy_.fields[static_cast<std::size_t>(field)].stops_at_edges = flies;
}

}  // namespace palpa
