// One move of the proxy: balance, the first event on the way, the end.
#include <algorithm>
#include <cmath>

#include "palpa/session/path_tolerances.h"
#include "palpa/session/proxy_path.h"

namespace palpa {

using namespace path_tolerances;

namespace {

constexpr int max_trials = 24;    // [1] balances per move. More: longer worst tick; fewer: moves are given up
constexpr int max_shutting = 8;   // [1] more of them, if a level has to be shut. Fewer: the proxy is given up on its path
constexpr double bound_m = 1e-8;  // [m] stop before a break-through. Less: decided by rounding; more: breaks early
constexpr int most_chords = 3;    // [1] searched for the first event of a turning tool. More: work; fewer: it stops beside it
constexpr double most_turn_rad = 0.3;  // [rad] of a move. More: levers change too much for one balance; less: more moves

}  // namespace

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
  return spacing_m_ * std::max(1.0, spared_work_ / (most_chords * all_feet_work));
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
