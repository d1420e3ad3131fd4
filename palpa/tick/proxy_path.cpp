#include "palpa/tick/proxy_path.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>

#include "palpa/core/split.h"

namespace palpa {

namespace {

constexpr std::size_t max_events = 16;
constexpr int most_refined = 16;
constexpr int max_friction_passes = 4;
constexpr double unbounded = std::numeric_limits<double>::infinity();
constexpr double trial_share = 1e-3;        // of a sample spacing: below, directions have not changed
constexpr double still_share = 1e-6;        // of a sample spacing: no move at all
constexpr double rest_share = 5e-4;         // of a sample spacing: a move that does not change by more is settled
constexpr double halted_share = 0.02;       // of a sample spacing: a move shortened below this is rest
constexpr double arrived_m = 1e-6;          // an event this close to the balance, or trial_share, is no stop
constexpr int max_passes = 8;               // of looking where a move ends
constexpr double straight_on = 0.99;        // cosine between two pieces of the probe's path, up to which moves are alike …
constexpr double expected_spacings = 0.25;  // … if they are no longer than this
constexpr int max_rounds = 4;               // of adding the kept planes that a balance is behind of
constexpr int most_still_steps = 4;         // a tick, in which a still hand is settled further than a moving one
constexpr int max_located = 4;              // places a tick where levels give way; beyond, they let go a sub-step early
constexpr int max_attempts = 3;             // of taking what a move runs into into the balance
constexpr double local_reach = 4.0;         // of a move that fails: planes beyond are not of its place
constexpr int max_halvings = 6;             // of a move that would raise the spring's energy
constexpr double hovering_share = 1e-2;     // of a sample spacing between the proxy and the level that a kept plane stands on
constexpr double piercing_share = 0.05;     // of a sample spacing: how deep a straight move may lead into what holds it
constexpr double bound_m = 1e-9;            // to which the place where a level gives way is located on the probe's path
constexpr double rounding = 1e-9;           // of a length: a piece as long as the longest move is not longer
constexpr double directed_n_per_s = 100.0;  // directed forces may change so fast because the data do
constexpr double hair_m = 1e-8;
constexpr double least_time_share = 1e-6;  // of a sub-step's time: a drag is never posed with none

// The part of the proxy's motion that is more than that of the probe and the data: a release, no motion of the hand.
Vec3 released(const Vec3& step_m, double moved_m) noexcept {
  const double length = norm(step_m);
  return length > moved_m ? (1.0 - moved_m / length) * step_m : Vec3{};
}

bool is_on(const Captured& level, const Captured& other) noexcept {
  return level.field == other.field && level.value == other.value;
}

}  // namespace

ProxyPath::ProxyPath(const Scene& scene, const Similarity& map, std::unique_ptr<Law> law)
    : stiffness_n_per_m_(scene.coupling.stiffness_n_per_m),
      time_(scene.time),
      law_(std::move(law)),
      in_steps_(law_->walk() == Law::Walk::steps),
      at_probe_(law_->placement() == Law::Placement::at_probe),
      modes_(scene, map),
      watches_(modes_.watches()),
      primitives_(max_primitives),
      held_(max_primitives),
      told_(modes_.size()) {
  own_n_.reserve(max_primitives);
  rubbed_.reserve(max_primitives);
  lines_.reserve(max_primitives);
  first_.reserve(max_primitives);
  entered_.reserve(modes_.size());
  crossings_.reserve(8 * watches_.size() + 8);
  events_.reserve(max_events);
  std::vector<std::int32_t> every_field(modes_.fields());
  std::iota(every_field.begin(), every_field.end(), 0);
  watches_.attend_edges(every_field);  // known from now on: later calls do not allocate
  watches_.attend_edges({});
  playing_ = modes_.samples().any_timed() && time_.play != TimeOptions::Play::hold;
  modes_.samples().set_time(time_.at(0.0));
  refine(1);
  reset();
}

void ProxyPath::reset() noexcept {
  course_.started = false;
  course_.queued = 0;
  course_.unfinished = false;
  course_.settling = false;
  course_.move_m = course_.probe_way_m = {};
  held_.clear();
  kept_.clear();
  rubbed_.clear();
  law_->reset();
  watches_.reset();
  modes_.start();
  for (Told& told : told_) {
    told.standing = {};
    told.through = false;
  }
  sub_steps_.clear();
  placed_.clear();
  events_.clear();
}

void ProxyPath::refine(int times) {
  refined_ = std::clamp(times, 1, most_refined);
  const auto steps = static_cast<std::size_t>(Session::max_sub_steps * refined_);
  sub_steps_.reserve(steps);
  placed_.reserve(steps * max_primitives);
}

void ProxyPath::continue_from(const ProxyPath& other) noexcept {
  modes_.continue_from(other.modes_);
  watches_ = other.watches_;
  held_ = other.held_;
  kept_ = other.kept_;
  rubbed_ = other.rubbed_;
  course_ = other.course_;
  for (std::size_t m = 0; m < told_.size(); ++m) told_[m] = other.told_[m];
  law_->reset();
}

void ProxyPath::emit(SessionEvent event) noexcept {
  if (events_.size() < max_events) events_.push_back(event);
}

bool ProxyPath::walk(const Vec3& probe_m, double time_step_s, Ledger& ledger) noexcept {
  sub_steps_.clear();
  placed_.clear();
  events_.clear();
  released_m_ = {};
  dropped_ = 0;
  located_ = 0;
  Course& c = course_;
  if (!c.started) {
    c.started = true;
    c.proxy = c.walked = probe_m;
    c.view_s = c.followed_s = c.elapsed_s - time_step_s;
    modes_.samples().set_time(time_.at(c.view_s));
    modes_.samples().move_to(c.proxy);
    watches_.look(modes_.samples());
  }
  modes_.prefetch(c.proxy);
  ledger.begin(c.proxy);
  for (Told& told : told_) told.met = told.broken = false;
  kept_.begin_tick();
  if (c.queued == max_queued) --c.queued;  // a path this long is no hand's: its last corner is cut
  path_m_ = distance(probe_m, c.queued > 0 ? c.queue[c.queued - 1].position_m : c.walked);
  if (playing_) path_m_ = std::max(path_m_, modes_.motion_m(c.proxy, time_.at(c.followed_s), time_.at(c.elapsed_s)));
  c.queue[c.queued++] = {probe_m, time_step_s};

  Piece piece;
  while (next_piece(piece)) {
    if (static_cast<int>(sub_steps_.size()) == Session::max_sub_steps * refined_) {
      sub_steps_.back().stop = Stop::cap;
      return false;
    }
    sub_step(piece, ledger);
  }
  return true;
}

// The longest step between two positions: half the finest sample spacing of what may be met there.
double ProxyPath::step_m(const Vec3& from_m, const Vec3& to_m) noexcept {
  return in_steps_ ? 0.5 * modes_.finest_m(from_m, to_m) / refined_ : unbounded;
}

bool ProxyPath::silent_at(const Vec3& at_m) noexcept {
  const bool silent = modes_.silent_at({at_m, at_m, 1.0, stiffness_n_per_m_}, at_m, primitives_, entered_);
  note_own();
  if (!silent) entered_.clear();
  return silent;
}

// Cuts the next piece off the probe's path, short enough that nothing in the data is jumped over. It stays in the
// queue until it is walked.
bool ProxyPath::next_piece(Piece& piece) noexcept {
  Course& c = course_;
  if (c.unfinished) {
    piece = {c.walked, c.walked, c.left_s, false};
    return true;
  }
  if (c.queued == 0) return false;
  const Waypoint& next = c.queue[0];
  const double length = distance(next.position_m, c.walked);
  double longest = step_m(c.walked, next.position_m);
  if (refined_ > 1) longest = std::min(longest, path_m_ / refined_);
  piece = {c.walked, next.position_m, next.time_s, true};
  // Neither the probe nor the data may go further.
  const double furthest =
      playing_ ? std::max(length, modes_.motion_m(c.proxy, time_.at(c.followed_s), time_.at(time_at_end_of(piece)))) : length;
  if (furthest > longest && !(c.proxy == c.walked && silent_at(c.proxy))) {
    const double share = (1.0 - rounding) * longest / furthest;
    piece.to_m = c.walked + share * (next.position_m - c.walked);
    piece.time_s = share * next.time_s;
  }
  return true;
}

// Seconds since the session began when the probe was at the end of a piece: what waits behind it is still to come.
double ProxyPath::time_at_end_of(const Piece& piece) const noexcept {
  const Course& c = course_;
  double to_come_s = 0.0;
  for (std::size_t i = c.queued; i-- > 1;) to_come_s += c.queue[i].time_s;
  return c.elapsed_s - (to_come_s + (c.queue[0].time_s - piece.time_s));
}

// Sees the data as they are at the end of a piece. Returns for how long they go on in it [s].
double ProxyPath::see(const Piece& piece, const Vec3& start_m) noexcept {
  Course& c = course_;
  const double view_s = piece.fresh ? std::max(c.view_s, time_at_end_of(piece)) : c.view_s;
  const double passed_s = view_s - c.view_s;
  keep_own();
  if (passed_s > 0.0) {
    modes_.samples().set_time(time_.at(view_s), time_.at(c.view_s));
    kept_.carry(modes_.samples());
  }
  modes_.go_on(start_m, time_.at(c.followed_s), time_.at(view_s), time_.at(c.elapsed_s), passed_s, primitives_,
               [&](std::size_t m) {
                 emit({SessionEventKind::warning, static_cast<std::int32_t>(m), 0.0,
                       "a level jumps between two frames instead of moving: its strength fades out and in"});
               });
  c.view_s = view_s;
  moved_n_ = 0.5 * stiffness_n_per_m_ * modes_.furthest_carried_m() + directed_n_per_s * passed_s;
  return view_s - c.followed_s;
}

// One balance along the path: place, balance, move towards it or to the first event, settle.
void ProxyPath::sub_step(Piece piece, Ledger& ledger) noexcept {
  Course& c = course_;
  const Vec3 start = c.proxy;
  const bool settling = c.settling;
  Situation situation{start, piece.to_m, piece.time_s, stiffness_n_per_m_};
  spacing_m_ = std::min(modes_.finest_m(start, piece.to_m), 1.0);  // without data any length will do
  const double follows_s = playing_ ? see(piece, start) : 0.0;
  double longest = step_m(start, piece.to_m);
  const auto move_to = [&](const Balance& to) { return distance(to.position_m, start); };
  const auto share_of_move = [&](const Balance& to) {
    const double length = move_to(to);
    return length > longest ? longest / length : 1.0;
  };

  // A long way is gone at once where nothing is felt and nothing sets in unseen.
  const bool free = distance(piece.to_m, start) > longest && silent_at(start);
  if (free) longest = unbounded;

  relaxed_ = false;
  Balance to;
  double change_m = 0.0;
  if (in_steps_ && !at_probe_) {
    change_m = approach(situation, expected_m(piece), longest, to);
  } else {
    situation.gone = at_probe_ ? 1.0 : 0.0;
    to = look(situation, at_probe_ ? piece.to_m : start, at_probe_ ? piece.to_m : start);
  }
  const bool again = !primitives_.empty() && in_steps_ && !at_probe_;
  double move_fraction = share_of_move(to);
  bool bound_met = piece.fresh && in_steps_ && meet_bound(piece, situation, to);
  if (bound_met) move_fraction = share_of_move(to);

  Stop stop = bound_met ? Stop::event : move_fraction < 1.0 ? Stop::release : Stop::full;
  crossings_.clear();
  attend_levels(to);
  if (!in_steps_) {
    // One step per tick stops nowhere; modes are told afterwards what it went through.
    Vec3 from = start;
    for (std::size_t i = 0; i < watches_.size(); ++i) {
      const Watches::Met met = watches_.first_crossing(modes_.samples(), from, to.position_m, crossings_);
      if (!met.stopped) break;
      from += met.share * (to.position_m - from);
    }
  } else {
    double wanted = move_fraction;
    Vec3 end;
    for (int attempt = 0;; ++attempt) {
      move_fraction = bound_met ? wanted : descending_share(to, start, piece.to_m, wanted);
      stop = bound_met ? Stop::event : wanted < 1.0 ? Stop::release : Stop::full;
      if (move_fraction < wanted) stop = Stop::energy;
      end = move_fraction < 1.0 ? start + move_fraction * (to.position_m - start) : to.position_m;
      const double outside = share_outside(to, start, end);
      if (move_fraction == wanted && outside == 1.0) break;
      if (attempt == max_attempts || !again || bound_met) {
        if (outside < 1.0) stop = Stop::event;
        move_fraction *= outside;
        end = start + move_fraction * (to.position_m - start);
        break;
      }
      // What the move has run into belongs into the balance.
      relaxed_ = attempt > 0;
      const Vec3 met_m = outside < 1.0 ? start + outside * (end - start) : start + wanted * (to.position_m - start);
      kept_.meet(primitives_);
      // Planes from further back than the move is long say nothing about what it meets.
      kept_.forget_beyond(start, local_reach * distance(met_m, start));
      to = look(situation, 0.5 * (start + met_m), met_m);
      if (outside == 1.0) change_m = approach(situation, to.position_m - start, longest, to);
      wanted = share_of_move(to);
      attend_levels(to);
    }
    if (free) watches_.attend_edges(entered_);
    const Watches::Met met = watches_.first_crossing(modes_.samples(), start, end, crossings_);
    if (free) watches_.attend_edges({});
    const double left_m = (1.0 - met.share) * (distance(end, start) + modes_.furthest_carried_m());
    // Where the balance is all but reached, what sets in is placed in the next sub-step anyway; to stop
    // would only divide the rest of the time without end.
    if (met.stopped && left_m > std::min(arrived_m, trial_share * spacing_m_)) {
      move_fraction *= met.share;
      stop = Stop::event;
    }
  }
  // A hand that moves is followed by the next tick anyway; a still one is to feel the end of it.
  const bool is_still = path_m_ == 0.0 && primitives_.size() == own_ && static_cast<int>(sub_steps_.size()) < most_still_steps;
  const double rest_m = (is_still ? still_share : rest_share) * spacing_m_;
  // Whether a finished move would be followed by another is only asked; the answer no is not worth a sub-step.
  if (settling && stop == Stop::full && move_to(to) <= rest_m) {
    c.unfinished = c.settling = false;
    modes_.arrive();
    return;
  }
  c.proxy = move_fraction == 1.0 ? to.position_m : start + move_fraction * (to.position_m - start);
  released_m_ += released(c.proxy - start, distance(piece.to_m, piece.from_m) + move_fraction * modes_.furthest_carried_m());

  // The probe's path is walked up to the piece's end; its rest stays in the queue.
  if (piece.fresh) {
    Waypoint& next = c.queue[0];
    c.walked = piece.to_m;
    c.whole_s = piece.time_s;
    next.time_s -= piece.time_s;
    if (piece.to_m == next.position_m) {
      std::copy(c.queue.begin() + 1, c.queue.begin() + static_cast<std::ptrdiff_t>(c.queued), c.queue.begin());
      --c.queued;
    }
  }
  const double went_m = distance(c.proxy, start);
  c.move_m = c.proxy - start;
  c.probe_way_m = piece.to_m - piece.from_m;
  const bool stays = stop == Stop::full || (bound_met && stop == Stop::event && move_fraction == 1.0);
  // The last sub-step of a tick is followed by another while directions may still change.
  // So is one that a plane from further back on the way holds.
  const bool held_by_kept = primitives_.size() > own_ && went_m > rest_share * spacing_m_;
  const bool settled = !held_by_kept && (settling || is_still ? went_m : change_m) <= rest_m;
  // A level that lets go leaves the proxy where it was pressed to: only the next balance is without it.
  const bool lets_go = a_shell_yields() && went_m > rest_share * spacing_m_;
  c.settling = stays && in_steps_ && c.queued == 0 && !primitives_.empty() && (!settled || lets_go);
  c.unfinished = c.settling || (stop == Stop::energy ? went_m > halted_share * spacing_m_ : !stays);
  c.followed_s = c.unfinished ? c.view_s - (1.0 - move_fraction) * follows_s : c.view_s;
  c.left_s = std::max(least_time_share * c.whole_s, (1.0 - move_fraction) * piece.time_s);

  SubStep step;
  step.time_step_s = piece.time_s;
  step.start_m = start;
  step.probe_m = piece.to_m;
  step.balance = to;
  step.move_fraction = move_fraction;
  step.stop = stop;
  step.proxy_m = c.proxy;
  record(step, ledger);
  held_.keep(primitives_, placed_at_m_);
  tell_contact(to, distance(to.position_m, piece.to_m));
  situation.probe_m = piece.to_m;
  situation.time_step_s = piece.time_s;
  situation.gone = move_fraction;
  modes_.settle(situation, c.proxy, primitives_, crossings_, [&](std::size_t i) { return state_of_level(i, to); });
  watches_.look(modes_.samples());
  kept_.meet(primitives_);
  kept_.end_step(primitives_, to, c.proxy, spacing_m_);
  modes_.arrive();
}

// What the data say at a place, balanced; of levels, what they say at the end of the move.
Balance ProxyPath::look(const Situation& situation, const Vec3& at_m, const Vec3& end_m) noexcept {
  modes_.place(situation, at_m, end_m, primitives_);
  placed_at_m_ = at_m;
  levels_at_m_ = end_m;
  if (in_steps_) {
    const std::int32_t fastest = held_.hold_back(primitives_, at_m, stiffness_n_per_m_, moved_n_);
    if (fastest >= 0 && !told_[static_cast<std::size_t>(fastest)].held_back) {
      told_[static_cast<std::size_t>(fastest)].held_back = true;
      emit({SessionEventKind::warning, fastest, 0.0,
            "a directed force changes faster than half the coupling's stiffness and is held back"});
    }
  }
  note_own();
  return balance(situation.probe_m, situation.time_step_s);
}

// Balances with the planes that are kept, which share their level's strength.
Balance ProxyPath::balance(const Vec3& probe_m, double time_s) noexcept {
  for (Told& told : told_) told.gives_way = false;
  keep_own();
  Balance found = solve(probe_m, time_s);
  const double slack_m = relaxed_ ? piercing_share * spacing_m_ : 0.0;
  // Where a surface is merely hollow each plane cuts the last ones by less than what counts as rest.
  const double behind_m = still_share * spacing_m_;
  for (int round = 0; round < max_rounds && in_steps_; ++round) {
    if (!kept_.add_to(primitives_, own_n_, found, behind_m, slack_m)) break;
    found = solve(probe_m, time_s);
  }
  const bool shared = primitives_.size() > own_;
  bool gives_way = yields(found, true);
  if (gives_way && shared && split_is_shared(primitives_.primitives(), found)) {
    // With others beside them the planes' sum is one of many. Each plane by itself slips or sticks, whatever the split.
    for (Told& told : told_) told.gives_way = false;
    for (std::size_t i = own_; i < primitives_.size(); ++i)
      primitives_.set_strength(i, primitives_[i].strength_n / KeptPlanes::wedge);
    for (std::size_t i = 0; i < own_; ++i) {
      if (primitives_.captured(i).any()) primitives_.set_strength(i, own_n_[i]);
    }
    found = solve(probe_m, time_s);
    gives_way = yields(found, false);
  }
  if (shared && (gives_way || is_off_level(found))) {
    keep_own();
    found = solve(probe_m, time_s);
  }
  return found;
}

// What is in the set is the modes' own.
void ProxyPath::note_own() noexcept {
  own_ = primitives_.size();
  own_n_.clear();
  for (const Primitive& p : primitives_.primitives()) own_n_.push_back(p.strength_n);
}

// Drops the kept planes, so that the modes' own have their own strengths.
void ProxyPath::keep_own() noexcept {
  primitives_.truncate(own_);
  for (std::size_t i = 0; i < own_; ++i) {
    if (primitives_.captured(i).any()) primitives_.set_strength(i, own_n_[i]);
  }
}

// Marks the modes whose level is pressed through: one of its planes, or all of them together, exert its strength.
bool ProxyPath::yields(const Balance& found, bool together) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < own_; ++i) {
    const Primitive& p = primitives_[i];
    const Captured& level = primitives_.captured(i);
    if (!level.any() || !(own_n_[i] > 0.0)) continue;
    Vec3 sum_n = law_->forces_n()[i];
    bool over = state_at(p, found) == PrimitiveState::slip;
    for (std::size_t j = own_; j < primitives_.size(); ++j) {
      if (primitives_[j].id.mode != p.id.mode || !is_on(primitives_.captured(j), level)) continue;
      sum_n += law_->forces_n()[j];
      over = over || state_at(primitives_[j], found) == PrimitiveState::slip;
    }
    if (over || (together && norm(sum_n) > own_n_[i])) any = told_[p.id.mode].gives_way = true;
  }
  return any;
}

// Kept planes that hold the proxy off the level itself bound no hollow; nor do the two sides of a thin wall, which hold it
// inside.
bool ProxyPath::is_off_level(const Balance& found) noexcept {
  Samples& samples = modes_.samples();
  for (std::size_t i = 0; i < own_; ++i) {
    const Captured& level = primitives_.captured(i);
    if (!level.any() || state_of_level(i, found) == PrimitiveState::off) continue;
    samples.move_to(levels_at_m_);
    const double side = dot(primitives_[i].direction, samples.scalar(level.field).gradient) < 0.0 ? 1.0 : -1.0;
    samples.move_to(primitives_.start_m());
    const double start = side * (samples.scalar(level.field).value - level.value);
    samples.move_to(found.position_m);
    const ScalarSample& sample = samples.scalar(level.field);
    const double inside = side * (sample.value - level.value);
    const double spacing = spacing_m_ * norm(sample.gradient);
    const bool hovers = state_at(primitives_[i], found) == PrimitiveState::off || relaxed_;
    if (hovers && -inside > hovering_share * spacing) return true;
    if (relaxed_ && inside > std::max(start, piercing_share * spacing)) return true;
  }
  return false;
}

// A shell that gives way lets the proxy go; a material is met again at once, where the proxy has got to.
bool ProxyPath::a_shell_yields() const noexcept {
  for (std::size_t i = 0; i < own_; ++i) {
    const Captured& level = primitives_.captured(i);
    if (level.any() && told_[primitives_[i].id.mode].gives_way && watches_.is_watched({level.field, level.value})) return true;
  }
  return false;
}

// Where a shell that held gives way within the piece, the piece ends there: found by halving the probe's path.
bool ProxyPath::meet_bound(Piece& piece, const Situation& situation, Balance& to) noexcept {
  const double length = distance(piece.to_m, piece.from_m);
  if (!a_shell_yields() || !(length > bound_m) || located_ == max_located) return false;
  const auto probe_at = [&](double share) { return piece.from_m + share * (piece.to_m - piece.from_m); };
  const auto holds_at = [&](double share) {
    to = balance(probe_at(share), std::max(share, least_time_share) * situation.time_step_s);
    return !a_shell_yields();
  };
  // Nearly all levels that give way have done so before: then it is there already.
  const double near = std::min(1.0, 2.0 * hair_m / length);
  if (!holds_at(near) || !holds_at(0.0)) {
    to = balance(piece.to_m, situation.time_step_s);
    return false;
  }
  double held = near, gone = 1.0;
  while ((gone - held) * length > bound_m) {
    const double middle = 0.5 * (held + gone);
    (holds_at(middle) ? held : gone) = middle;
  }
  // A hair before it: there no rounding of forces decides whether the level holds.
  held -= hair_m / length;
  if (held * length <= hair_m) {  // it is there already: now it lets go
    to = balance(piece.to_m, situation.time_step_s);
    return false;
  }
  holds_at(gone);
  ++located_;
  for (Told& told : told_) told.at_bound = told.gives_way;
  piece.to_m = probe_at(held);
  piece.time_s = held * situation.time_step_s;
  to = balance(piece.to_m, piece.time_s);
  return true;
}

// How strong the friction of a line is by the force of its plane, or planes, in the last balance [N].
double ProxyPath::friction_n(std::size_t i) const noexcept {
  const Friction& friction = primitives_.friction_of(i);
  const auto plane = static_cast<std::size_t>(friction.plane);
  double pressed_n = norm(law_->forces_n()[plane]);
  for (std::size_t j = own_; j < primitives_.size(); ++j) {
    if (primitives_[j].id.mode == primitives_[plane].id.mode && is_on(primitives_.captured(j), primitives_.captured(plane)))
      pressed_n += norm(law_->forces_n()[j]);
  }
  return friction.coefficient * pressed_n;
}

// Balances, with Coulomb friction as strong as its plane in this very sub-step: a fixed point, which the last balance is
// near to; a secant finds it in two or three. Where the plane shares its load with others, its force is that of one split of
// several, the law's, and so is the friction.
Balance ProxyPath::solve(const Vec3& probe_m, double time_s) noexcept {
  const double k = stiffness_n_per_m_;
  lines_.clear();
  for (std::size_t i = 0; i < own_; ++i) {
    if (!primitives_.friction_of(i).any()) continue;
    const PrimitiveId& id = primitives_[i].id;
    const auto before = std::find_if(rubbed_.begin(), rubbed_.end(), [&](const Rubbed& r) { return r.id == id; });
    if (before == rubbed_.end()) {
      lines_.push_back({id, i});
    } else {
      lines_.push_back({id, i, before->strength_n, before->slope});
    }
    primitives_.set_strength(i, lines_.back().strength_n);
  }
  Balance found = law_->solve(primitives_, primitives_.start_m(), probe_m, k, time_s);
  if (lines_.empty()) return found;
  for (int pass = 0; pass < max_friction_passes; ++pass) {
    bool changed = false;
    for (Rubbed& line : lines_) {
      const double wanted_n = friction_n(line.index);
      // A line that holds the proxy holds it with any strength above its force.
      const bool holds = norm(law_->forces_n()[line.index]) < std::min(wanted_n, 0.999 * line.strength_n);
      const double off_n = wanted_n - line.strength_n;
      const double step_n = line.strength_n - line.before_n;
      if (pass > 0 && step_n != 0.0) line.slope = std::clamp((wanted_n - line.wanted_n) / step_n, -1.0, 0.5);
      if (holds || std::abs(off_n) <= exact_bound_m * k) {
        if (holds) primitives_.set_strength(line.index, line.strength_n = wanted_n);
        continue;
      }
      line.before_n = line.strength_n;
      line.wanted_n = wanted_n;
      line.strength_n = std::max(0.0, line.strength_n + off_n / (1.0 - line.slope));
      primitives_.set_strength(line.index, line.strength_n);
      changed = true;
    }
    if (!changed) break;
    const int iterations = found.iterations;
    found = law_->solve(primitives_, primitives_.start_m(), probe_m, k, time_s);
    found.iterations += iterations;
  }
  std::swap(rubbed_, lines_);
  return found;
}

// The state of a primitive as its mode is told: of a plane on a level, that of the level, whichever of its planes holds.
PrimitiveState ProxyPath::state_of_level(std::size_t i, const Balance& at) const noexcept {
  const Primitive& p = primitives_[i];
  const Captured& level = primitives_.captured(i);
  PrimitiveState state = state_at(p, at);
  if (!level.any()) return state;
  if (told_[p.id.mode].gives_way) return state == PrimitiveState::off ? state : PrimitiveState::slip;
  for (std::size_t j = own_; j < primitives_.size() && state == PrimitiveState::off; ++j) {
    if (primitives_[j].id.mode == p.id.mode && is_on(primitives_.captured(j), level) &&
        state_at(primitives_[j], at) != PrimitiveState::off) {
      state = PrimitiveState::stick;
    }
  }
  return state;
}

// Where the proxy would get to if it moved on as it did in the last sub-step, by as much more or less as the probe does.
Vec3 ProxyPath::expected_m(const Piece& piece) const noexcept {
  const Vec3 way_m = piece.to_m - piece.from_m;
  const double straight = dot(way_m, course_.probe_way_m);
  const double before_m2 = norm_squared(course_.probe_way_m);
  const bool goes_on =
      piece.fresh && !playing_ && before_m2 > 0.0 && straight > straight_on * std::sqrt(norm_squared(way_m) * before_m2);
  if (!goes_on) return {};
  const Vec3 move_m = straight / before_m2 * course_.move_m;
  return norm(move_m) <= expected_spacings * spacing_m_ ? move_m : Vec3{};
}

// Looks until that changes nothing: at the middle of the move for directions, since a line looked up where it
// begins would let the proxy leave every curve on its outside; at its end for levels, which hold the proxy there. In a
// hollow each look meets another plane of it, as in the method of cutting planes. The first look is where the move is
// expected to go. Returns how far the last look moved the end [m].
double ProxyPath::approach(const Situation& situation, const Vec3& expected_m, double longest, Balance& to) noexcept {
  const Vec3& start = situation.start_m;
  const auto end_of = [&](const Vec3& to_m) {
    const Vec3 move = to_m - start;
    const double length = norm(move);
    return length > longest ? start + longest / length * move : to_m;
  };
  first_.clear();
  for (std::size_t i = 0; i < own_; ++i) first_.push_back(primitives_[i]);
  double whole_m = norm(expected_m);
  Vec3 end = end_of(start + expected_m);
  for (int pass = 0;; ++pass) {
    for (int halving = 0;; ++halving) {
      Situation middle = situation;
      middle.gone = whole_m > 0.0 ? 0.5 * std::min(1.0, distance(end, start) / whole_m) : 0.0;
      // A clipped move is a chord: as long as it is parallel to the level at its middle, both ends lie on the level.
      to = look(middle, 0.5 * (start + end), whole_m > longest ? 0.5 * (start + end) : end);
      if (halving == max_halvings || end == start || relaxed_ || !is_other_sheet(start)) break;
      end = 0.5 * (start + end);
    }
    if (primitives_.empty()) return 0.0;
    if (end == start) {
      first_.clear();
      for (std::size_t i = 0; i < own_; ++i) first_.push_back(primitives_[i]);
    }
    const Vec3 before = end;
    whole_m = distance(to.position_m, start);
    end = end_of(to.position_m);
    const double change_m = distance(end, before);
    if (before != start && (change_m <= rest_share * spacing_m_ || pass >= max_passes)) return change_m;
    if (distance(end, start) <= trial_share * spacing_m_) return 0.0;
    kept_.meet(primitives_);
  }
}

// Whether a level was looked for on the far side of a thin wall: the plane found there faces away from the one at the
// start, and the start is behind it.
bool ProxyPath::is_other_sheet(const Vec3& start_m) const noexcept {
  for (std::size_t i = 0; i < std::min(own_, first_.size()); ++i) {
    const Primitive& p = primitives_[i];
    if (p.id == first_[i].id && primitives_.captured(i).any() && dot(p.direction, first_[i].direction) < 0.0 &&
        dot(p.direction, p.position_m - start_m) > 0.0) {
      return true;
    }
  }
  return false;
}

// How levels count while the proxy moves, by the planes that stand on them.
void ProxyPath::attend_levels(const Balance& to) noexcept {
  using Attention = Watches::Attention;
  watches_.attend_all();
  if (playing_) modes_.attend(watches_, course_.proxy);
  for (std::size_t i = 0; i < own_; ++i) {
    const Captured& level = primitives_.captured(i);
    if (!level.any() || !(own_n_[i] > 0.0)) continue;
    const PrimitiveState state = state_of_level(i, to);
    if (state == PrimitiveState::stick) watches_.attend({level.field, level.value}, Attention::held);
    if (state != PrimitiveState::off) continue;
    modes_.samples().move_to(levels_at_m_);
    const bool up = dot(modes_.samples().scalar(level.field).gradient, primitives_[i].direction) > 0.0;
    watches_.attend({level.field, level.value}, up ? Attention::leave_up : Attention::leave_down);
  }
}

// The share of the move after which the spring has less energy than before, both points put back on the
// levels that hold the proxy. In a crease of a surface each side's plane leads into the other side; a
// full move would swing from one to the other for ever, a descending one comes to rest at the bottom.
double ProxyPath::descending_share(const Balance& to, const Vec3& start, const Vec3& probe_m, double share) noexcept {
  Vec3 directed_n;
  bool any = false;
  for (std::size_t i = 0; i < own_; ++i) {
    const Primitive& p = primitives_[i];
    if (p.kind == PrimitiveKind::directed) directed_n += p.strength_n * p.direction;
    any = any || (primitives_.captured(i).any() && p.strength_n > 0.0);
  }
  for (std::size_t m = 0; m < modes_.size(); ++m) any = any && !modes_.fades(m);  // that level is where the proxy is not yet
  const Vec3 move = to.position_m - start;
  if (!any || share * norm(move) <= still_share * spacing_m_) return share;
  const auto put_back = [&](const Vec3& x) {
    Vec3 on_level = x;
    for (std::size_t i = 0; i < own_; ++i) {
      const Captured& level = primitives_.captured(i);
      if (!level.any() || !(primitives_[i].strength_n > 0.0) || state_of_level(i, to) != PrimitiveState::stick) continue;
      modes_.samples().move_to(on_level);
      const ScalarSample& sample = modes_.samples().scalar(level.field);
      const double steepness = norm(sample.gradient);
      if (!sample.inside || !(steepness > 0.0)) continue;
      on_level += std::clamp((level.value - sample.value) / steepness, -spacing_m_, spacing_m_) * normalized(sample.gradient);
    }
    return on_level;
  };
  const Vec3 before = put_back(start);
  const double off_m = distance(before, start);
  const bool is_off = off_m > piercing_share * spacing_m_;
  const auto descends = [&](const Vec3& from, const Vec3& after, double allowed) {
    // As a product: the difference of two squares would lose its digits.
    const Vec3 pull_n = stiffness_n_per_m_ * (0.5 * (from + after) - probe_m) - directed_n;
    return dot(after - from, pull_n) <= allowed * spacing_m_ * norm(pull_n);
  };
  for (int halving = 0; halving < max_halvings; ++halving, share *= 0.5) {
    const Vec3 after = put_back(start + share * move);
    // A proxy that is off its level has to come back, whatever that costs.
    if (is_off ? distance(after, start + share * move) < off_m : descends(before, after, 0.0)) return share;
    // Data may carry the proxy against the spring, as far as they go themselves.
    for (std::size_t m = 0; modes_.any_carried() && m < modes_.size(); ++m) {
      const Vec3& carried_m = modes_.carried_m(m);
      if (carried_m != Vec3{} && descends(put_back(start + share * carried_m), after, trial_share)) return share;
    }
  }
  return 0.0;
}

// The share of a move after which the proxy would be inside of what holds it: another wall of the same level, or the other
// side of a corner. Levels that hold are on no list of crossings, so they are looked for here.
double ProxyPath::share_outside(const Balance& to, const Vec3& start, const Vec3& end) noexcept {
  double share = 1.0;
  if (distance(start, end) <= piercing_share * spacing_m_) return share;
  Samples& samples = modes_.samples();
  for (std::size_t i = 0; i < own_; ++i) {
    const Captured& level = primitives_.captured(i);
    if (!level.any() || !(own_n_[i] > 0.0) || state_of_level(i, to) == PrimitiveState::slip) continue;
    samples.move_to(levels_at_m_);  // where the plane's normal was read
    const Vec3 uphill = samples.scalar(level.field).gradient;
    const bool solid_is_high = dot(uphill, primitives_[i].direction) < 0.0;
    const double margin = piercing_share * spacing_m_ * norm(uphill);
    samples.move_to(start);
    const double here = samples.scalar(level.field).value;
    // From where the proxy is, if it is inside already.
    const double value = solid_is_high ? std::max(level.value, here) + margin : std::min(level.value, here) - margin;
    share = std::min(share, first_beyond(samples, level.field, value, solid_is_high, start, end));
  }
  return share;
}

// Onsets and break-throughs, each told once a tick for each mode; refusals, once.
void ProxyPath::tell_contact(const Balance& at, double depth_m) noexcept {
  for (std::size_t m = 0; m < told_.size(); ++m) {
    Told& told = told_[m];
    Captured standing;
    bool through = false;
    for (std::size_t i = 0; i < own_ && !standing.any(); ++i) {
      const Primitive& p = primitives_[i];
      if (p.id.mode != m || !primitives_.captured(i).any() || !(p.strength_n > 0.0)) continue;
      const PrimitiveState state = state_of_level(i, at);
      if (state == PrimitiveState::off) continue;
      standing = primitives_.captured(i);
      through = (state == PrimitiveState::slip || told.at_bound) && !modes_.fades(m);
    }
    told.at_bound = false;
    through = through || (told.through && is_on(standing, told.standing));
    const auto mode = static_cast<std::int32_t>(m);
    const bool meets = standing.any() && !told.standing.any() && !told.met;
    const bool breaks = through && !told.through && !told.broken;
    told.met = told.met || meets;
    told.broken = told.broken || breaks;
    if (meets) emit({SessionEventKind::onset, mode, standing.value, nullptr});
    if (breaks) emit({SessionEventKind::break_through, mode, standing.value, nullptr, depth_m});
    told.standing = standing;
    told.through = through;
  }
  for (const Refused& refused : primitives_.refused()) {
    Told& told = told_[refused.id.mode];
    const std::uint32_t bit = 1u << static_cast<unsigned>(refused.reason);
    if ((told.refusals & bit) == 0) {
      told.refusals |= bit;
      emit({SessionEventKind::fault, refused.id.mode, 0.0, sentence_of(refused.reason)});
    }
  }
}

void ProxyPath::record(SubStep step, Ledger& ledger) noexcept {
  const double k = stiffness_n_per_m_;
  const std::span<const Vec3> forces = law_->forces_n();
  const Vec3& position_m = step.balance.position_m;
  double held_n = 0.0;
  step.stiffness_n_per_m = k;
  step.first_primitive = static_cast<std::uint32_t>(placed_.size());
  step.primitives = static_cast<std::uint32_t>(primitives_.size());
  for (std::size_t i = 0; i < primitives_.size(); ++i) {
    Primitive p = primitives_[i];
    // A side of a wedge was given more than it needed. With any strength that is not below its force it holds the same.
    if (primitives_.captured(i).any() && primitives_.size() > own_)
      p.strength_n = std::min(p.strength_n, std::max(p.strength_n / KeptPlanes::wedge, (1.0 + 1e-12) * norm(forces[i])));
    const Vec3& carried_m = modes_.carried_m(p.id.mode);
    placed_.push_back({p, primitives_.captured(i), forces[i], state_at(p, step.balance), carried_m});
    if (p.kind == PrimitiveKind::directed) step.directed_n += forces[i];
    if (placed_.back().state == PrimitiveState::stick) held_n += p.strength_n + norm(forces[i]);
    ledger.book(p.id.mode, forces[i], step.proxy_m - step.start_m, step.move_fraction * carried_m);
  }
  const auto energy_j = [&](const Vec3& x) {
    return 0.5 * k * norm_squared(x - step.probe_m) - dot(step.directed_n, x - step.start_m);
  };
  // The law's bound is about the balance before its position was rounded to what is recorded. Whoever checks
  // the record by the duality gap pays a root for that rounding where the proxy rests on something.
  const double rounding_m =
      0.5 * std::numeric_limits<double>::epsilon() * (std::abs(position_m.x) + std::abs(position_m.y) + std::abs(position_m.z));
  // A bound b = (ρ + √(ρ² + 4kε)) / 2k has ρ ≤ kb; with e more of gap it is at most (b + √(b² + 4e/k)) / 2.
  double& bound_m = step.balance.error_bound_m;
  bound_m = 0.5 * (bound_m + std::sqrt(bound_m * bound_m + 4.0 * held_n * rounding_m / k));
  if (step.balance.status == BalanceStatus::exact && bound_m > exact_bound_m) step.balance.status = BalanceStatus::capped;
  dropped_ += primitives_.dropped();
  step.energy_before_j = energy_j(step.start_m);
  step.energy_after_j = energy_j(step.proxy_m);
  sub_steps_.push_back(step);
}

}  // namespace palpa
