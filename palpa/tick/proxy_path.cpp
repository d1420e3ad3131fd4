#include "palpa/tick/proxy_path.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "palpa/tick/move_limits.h"
#include "palpa/tick/path_tolerances.h"

namespace palpa {

using namespace path_tolerances;

namespace {

constexpr int most_refined = 16;
constexpr double unbounded = std::numeric_limits<double>::infinity();
constexpr double arrived_m = 1e-6;          // an event this close to the balance, or a trial move's length, is no stop
constexpr int max_passes = 8;               // of looking where a move ends
constexpr double straight_on = 0.99;        // cosine between two pieces of the probe's path, up to which moves are alike …
constexpr double expected_spacings = 0.25;  // … if they are no longer than this
constexpr int most_still_steps = 4;         // a tick, in which a still hand is settled further than a moving one
constexpr int max_located = 4;              // places a tick where levels give way; beyond, they let go a sub-step early
constexpr int max_attempts = 3;             // of taking what a move runs into into the balance
constexpr double local_reach = 4.0;         // of a move that fails: planes beyond are not of its place
constexpr int max_halvings = 6;             // of a move that ends on the other sheet of a wall
constexpr double bound_m = 1e-9;            // to which the place where a level gives way is located on the probe's path
constexpr double hair_m = 1e-8;             // before that place no rounding of forces decides
constexpr double rounding = 1e-9;           // of a length: a piece as long as the longest move is not longer
constexpr double directed_n_per_s = 100.0;  // directed forces may change so fast because the data do
constexpr double least_time_share = 1e-6;   // of a sub-step's time: a drag is never posed with none

// The part of the proxy's motion that is more than that of the probe and the data: a release, no motion of the hand.
Vec3 released(const Vec3& step_m, double moved_m) noexcept {
  const double length = norm(step_m);
  return length > moved_m ? (1.0 - moved_m / length) * step_m : Vec3{};
}

}  // namespace

ProxyPath::ProxyPath(const Scene& scene, const Similarity& map, std::unique_ptr<Law> law)
    : stiffness_n_per_m_(scene.coupling.stiffness_n_per_m),
      time_(scene.time),
      in_steps_(law->walk() == Law::Walk::steps),
      at_probe_(law->placement() == Law::Placement::at_probe),
      modes_(scene, map),
      watches_(modes_.watches()),
      joint_(std::move(law), modes_.size(), scene.coupling.stiffness_n_per_m, modes_.samples()),
      held_(max_primitives),
      events_(modes_.size()) {
  first_.reserve(max_primitives);
  entered_.reserve(modes_.size());
  crossings_.reserve(8 * watches_.size() + 8);
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
  joint_.clear();
  watches_.reset();
  modes_.start();
  events_.clear();
  sub_steps_.clear();
  placed_.clear();
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
  joint_.continue_from(other.joint_);
  course_ = other.course_;
  events_.continue_from(other.events_);
}

bool ProxyPath::walk(const Vec3& probe_m, double time_step_s, Ledger& ledger) noexcept {
  sub_steps_.clear();
  placed_.clear();
  events_.begin_tick();
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
  ledger.begin(c.proxy, c.walked);
  joint_.kept().begin_tick();
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
  const bool silent = modes_.silent_at({at_m, at_m, 1.0, stiffness_n_per_m_}, at_m, joint_.set(), entered_);
  joint_.pose({spacing_m_, at_m, false});
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
  joint_.keep_own();
  if (passed_s > 0.0) {
    modes_.samples().set_time(time_.at(view_s), time_.at(c.view_s));
    joint_.kept().carry(modes_.samples());
  }
  modes_.go_on(start_m, time_.at(c.followed_s), time_.at(view_s), time_.at(c.elapsed_s), passed_s, joint_.set(),
               [&](std::size_t m) {
                 events_.warn(m, "a level jumps between two frames instead of moving: its strength fades out and in");
               });
  c.view_s = view_s;
  moved_n_ = 0.5 * stiffness_n_per_m_ * modes_.furthest_carried_m() + directed_n_per_s * passed_s;
  return view_s - c.followed_s;
}

// One balance along the path: place, balance, move towards it or to the first event, settle.
void ProxyPath::sub_step(Piece piece, Ledger& ledger) noexcept {
  const Vec3 start = course_.proxy;
  Situation situation{start, piece.to_m, piece.time_s, stiffness_n_per_m_};
  spacing_m_ = std::min(modes_.finest_m(start, piece.to_m), 1.0);  // without data any length will do
  const double follows_s = playing_ ? see(piece, start) : 0.0;
  relaxed_ = false;
  crossings_.clear();
  const Move move = in_steps_ ? step(piece, situation) : leap(piece, situation);

  // A hand that moves is followed by the next tick anyway; a still one is to feel the end of it.
  const bool is_still = path_m_ == 0.0 && !joint_.any_kept() && static_cast<int>(sub_steps_.size()) < most_still_steps;
  const double rest_m = (is_still ? still : rest) * spacing_m_;
  // Whether a finished move would be followed by another is only asked; the answer no is not worth a sub-step.
  if (course_.settling && move.stop == Stop::full && distance(move.to.position_m, start) <= rest_m) {
    course_.unfinished = course_.settling = false;
    modes_.arrive();
    return;
  }
  // The last sub-step of a tick is followed by another while directions may still change.
  // So is one that a plane from further back on the way holds.
  const double went_m = distance(move.end_from(start), start);
  const bool held_by_kept = joint_.any_kept() && went_m > rest * spacing_m_;
  const bool settled = !held_by_kept && (course_.settling || is_still ? went_m : move.change_m) <= rest_m;
  // A level that lets go leaves the proxy where it was pressed to: only the next balance is without it.
  const bool lets_go = a_shell_yields() && went_m > rest * spacing_m_;
  go_on(piece, move, follows_s, settled && !lets_go);

  SubStep recorded;
  recorded.time_step_s = piece.time_s;
  recorded.start_m = start;
  recorded.probe_m = piece.to_m;
  recorded.balance = move.to;
  recorded.move_fraction = move.fraction;
  recorded.stop = move.stop;
  recorded.proxy_m = course_.proxy;
  record(recorded, ledger);
  held_.keep(joint_.set(), placed_at_m_);
  events_.tell(joint_, modes_, move.to, distance(move.to.position_m, piece.to_m));
  situation.probe_m = piece.to_m;
  situation.time_step_s = piece.time_s;
  situation.gone = move.fraction;
  modes_.settle(situation, course_.proxy, joint_.set(), crossings_, [&](std::size_t i) { return joint_.state_of(i, move.to); });
  press_through();
  watches_.look(modes_.samples());
  joint_.kept().meet(joint_.set());
  joint_.kept().end_step(joint_.set(), move.to, course_.proxy, spacing_m_);
  modes_.arrive();
}

// The proxy has moved; what is left of the piece is taken up again where the move was stopped.
void ProxyPath::go_on(const Piece& piece, const Move& move, double follows_s, bool settled) noexcept {
  Course& c = course_;
  const Vec3 start = c.proxy;
  c.proxy = move.end_from(start);
  c.move_m = c.proxy - start;
  c.probe_way_m = piece.to_m - piece.from_m;
  released_m_ += released(c.move_m, norm(c.probe_way_m) + move.fraction * modes_.furthest_carried_m());

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
  const bool stays = move.stop == Stop::full || (move.bound_met && move.stop == Stop::event && move.fraction == 1.0);
  c.settling = stays && in_steps_ && c.queued == 0 && !joint_.set().empty() && !settled;
  c.unfinished = c.settling || (move.stop == Stop::energy ? norm(c.move_m) > halted * spacing_m_ : !stays);
  c.followed_s = c.unfinished ? c.view_s - (1.0 - move.fraction) * follows_s : c.view_s;
  c.left_s = std::max(least_time_share * c.whole_s, (1.0 - move.fraction) * piece.time_s);
}

// Moves towards the balance as far as the data let it, at most half a sample spacing.
ProxyPath::Move ProxyPath::step(Piece& piece, Situation& situation) noexcept {
  const Vec3& start = situation.start_m;
  double longest = step_m(start, piece.to_m);
  // A long way is gone at once where nothing is felt and nothing sets in unseen.
  const bool free = distance(piece.to_m, start) > longest && silent_at(start);
  if (free) longest = unbounded;

  Move move;
  if (at_probe_) {
    situation.gone = 1.0;
    move.to = look(situation, piece.to_m, piece.to_m);
  } else {
    move.change_m = approach(situation, expected_m(piece), longest, move.to);
  }
  move.bound_met = piece.fresh && meet_bound(piece, situation, move.to);
  limit(piece, situation, longest, move);

  const Vec3 end = move.end_from(start);
  if (free) watches_.attend_edges(entered_);
  const Watches::Met met = watches_.first_crossing(modes_.samples(), start, end, crossings_);
  if (free) watches_.attend_edges({});
  const double left_m = (1.0 - met.share) * (distance(end, start) + modes_.furthest_carried_m());
  // Where the balance is all but reached, what sets in is placed in the next sub-step anyway; to stop
  // would only divide the rest of the time without end.
  if (met.stopped && left_m > std::min(arrived_m, trial * spacing_m_)) {
    move.fraction *= met.share;
    move.stop = Stop::event;
  }
  return move;
}

// How much of the way to the balance may be gone: not beyond the longest move, not uphill, not into what holds the proxy.
// What the move runs into belongs into the balance, which is then another one.
void ProxyPath::limit(const Piece& piece, const Situation& situation, double longest, Move& move) noexcept {
  const Vec3& start = situation.start_m;
  const bool again = !joint_.set().empty() && !at_probe_ && !move.bound_met;
  for (int attempt = 0;; ++attempt) {
    const double length = distance(move.to.position_m, start);
    const double wanted = length > longest ? longest / length : 1.0;
    attend_levels(move.to);
    const MoveLimits limits(joint_, modes_, start, piece.to_m, stiffness_n_per_m_, move.to);
    move.fraction = move.bound_met ? wanted : limits.descending_share(wanted);
    move.stop = move.bound_met ? Stop::event : wanted < 1.0 ? Stop::release : Stop::full;
    if (move.fraction < wanted) move.stop = Stop::energy;
    const Vec3 end = move.end_from(start);
    const double outside = limits.share_outside(end);
    if (move.fraction == wanted && outside == 1.0) return;
    if (attempt == max_attempts || !again) {
      if (outside < 1.0) move.stop = Stop::event;
      move.fraction *= outside;
      return;
    }
    relaxed_ = attempt > 0;
    const Vec3 met_m = outside < 1.0 ? start + outside * (end - start) : start + wanted * (move.to.position_m - start);
    joint_.kept().meet(joint_.set());
    // Planes from further back than the move is long say nothing about what it meets.
    joint_.kept().forget_beyond(start, local_reach * distance(met_m, start));
    move.to = look(situation, 0.5 * (start + met_m), met_m);
    if (outside == 1.0) move.change_m = approach(situation, move.to.position_m - start, longest, move.to);
  }
}

// One step per tick stops nowhere; modes are told afterwards what it went through.
ProxyPath::Move ProxyPath::leap(const Piece& piece, Situation& situation) noexcept {
  const Vec3& start = situation.start_m;
  situation.gone = at_probe_ ? 1.0 : 0.0;
  const Vec3& at_m = at_probe_ ? piece.to_m : start;
  Move move;
  move.to = look(situation, at_m, at_m);
  attend_levels(move.to);
  Vec3 from = start;
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    const Watches::Met met = watches_.first_crossing(modes_.samples(), from, move.to.position_m, crossings_);
    if (!met.stopped) break;
    from += met.share * (move.to.position_m - from);
  }
  return move;
}

// What the data say at a place, balanced; of levels, what they say at the end of the move.
Balance ProxyPath::look(const Situation& situation, const Vec3& at_m, const Vec3& end_m) noexcept {
  modes_.place(situation, at_m, end_m, joint_.set());
  placed_at_m_ = at_m;
  if (in_steps_) {
    const std::int32_t fastest = held_.hold_back(joint_.set(), at_m, stiffness_n_per_m_, moved_n_);
    if (fastest >= 0) events_.tell_held_back(static_cast<std::size_t>(fastest));
  }
  joint_.pose({spacing_m_, end_m, relaxed_});
  return joint_.balance(situation.probe_m, situation.time_step_s);
}

// A shell that gives way lets the proxy go; a material is met again at once, where the proxy has got to.
bool ProxyPath::a_shell_yields() const noexcept {
  for (std::size_t i = 0; i < joint_.own(); ++i) {
    const Captured& level = joint_.set().captured(i);
    if (level.any() && joint_.gives_way(joint_.set()[i].id.mode) && watches_.is_watched({level.field, level.value}))
      return true;
  }
  return false;
}

// A shell that gives way counts as crossed, wherever the proxy is: on an edge of the surface its planes may lead back out of
// it, and it would be met, and give way, in every sub-step.
void ProxyPath::press_through() noexcept {
  for (std::size_t i = 0; i < joint_.own(); ++i) {
    const Captured& level = joint_.set().captured(i);
    if (!level.any() || !joint_.gives_way(joint_.set()[i].id.mode)) continue;
    Samples& samples = modes_.samples();
    samples.move_to(joint_.terms().levels_at_m);
    const bool solid_is_high = dot(samples.scalar(level.field).gradient, joint_.set()[i].direction) < 0.0;
    watches_.take_side({level.field, level.value}, solid_is_high);
    samples.move_to(course_.proxy);
  }
}

// Where a shell that held gives way within the piece, the piece ends there: found by halving the probe's path.
bool ProxyPath::meet_bound(Piece& piece, const Situation& situation, Balance& to) noexcept {
  const double length = distance(piece.to_m, piece.from_m);
  if (!a_shell_yields() || !(length > bound_m) || located_ == max_located) return false;
  const auto probe_at = [&](double share) { return piece.from_m + share * (piece.to_m - piece.from_m); };
  const auto holds_at = [&](double share) {
    to = joint_.balance(probe_at(share), std::max(share, least_time_share) * situation.time_step_s);
    return !a_shell_yields();
  };
  // Nearly all levels that give way have done so before: then it is there already.
  const double near = std::min(1.0, 2.0 * hair_m / length);
  if (!holds_at(near) || !holds_at(0.0)) {
    to = joint_.balance(piece.to_m, situation.time_step_s);
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
    to = joint_.balance(piece.to_m, situation.time_step_s);
    return false;
  }
  holds_at(gone);
  ++located_;
  events_.stop_at_bound(joint_);
  piece.to_m = probe_at(held);
  piece.time_s = held * situation.time_step_s;
  to = joint_.balance(piece.to_m, piece.time_s);
  return true;
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
  for (std::size_t i = 0; i < joint_.own(); ++i) first_.push_back(joint_.set()[i]);
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
    if (joint_.set().empty()) return 0.0;
    if (end == start) {
      first_.clear();
      for (std::size_t i = 0; i < joint_.own(); ++i) first_.push_back(joint_.set()[i]);
    }
    const Vec3 before = end;
    whole_m = distance(to.position_m, start);
    end = end_of(to.position_m);
    const double change_m = distance(end, before);
    if (before != start && (change_m <= rest * spacing_m_ || pass >= max_passes)) return change_m;
    if (distance(end, start) <= trial * spacing_m_) return 0.0;
    joint_.kept().meet(joint_.set());
  }
}

// Whether a level was looked for on the far side of a thin wall: the plane found there faces away from the one at the
// start, and the start is behind it.
bool ProxyPath::is_other_sheet(const Vec3& start_m) const noexcept {
  for (std::size_t i = 0; i < std::min(joint_.own(), first_.size()); ++i) {
    const Primitive& p = joint_.set()[i];
    if (p.id == first_[i].id && joint_.set().captured(i).any() && dot(p.direction, first_[i].direction) < 0.0 &&
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
  for (std::size_t i = 0; i < joint_.own(); ++i) {
    const Captured& level = joint_.set().captured(i);
    if (!level.any() || !(joint_.own_n(i) > 0.0)) continue;
    const PrimitiveState state = joint_.state_of(i, to);
    if (state == PrimitiveState::stick) watches_.attend({level.field, level.value}, Attention::held);
    if (state != PrimitiveState::off) continue;
    modes_.samples().move_to(joint_.terms().levels_at_m);
    const bool up = dot(modes_.samples().scalar(level.field).gradient, joint_.set()[i].direction) > 0.0;
    watches_.attend({level.field, level.value}, up ? Attention::leave_up : Attention::leave_down);
  }
}

void ProxyPath::record(SubStep step, Ledger& ledger) noexcept {
  const double k = stiffness_n_per_m_;
  const std::span<const Vec3> forces = joint_.law().forces_n();
  const Vec3& position_m = step.balance.position_m;
  double held_n = 0.0;
  double furthest_carried_m = 0.0;
  step.stiffness_n_per_m = k;
  step.first_primitive = static_cast<std::uint32_t>(placed_.size());
  step.primitives = static_cast<std::uint32_t>(joint_.set().size());
  for (std::size_t i = 0; i < joint_.set().size(); ++i) {
    Primitive p = joint_.set()[i];
    // A side of a wedge was given more than it needed. With any strength that is not below its force it holds the same.
    if (joint_.set().captured(i).any() && joint_.any_kept())
      p.strength_n = std::min(p.strength_n, std::max(p.strength_n / KeptPlanes::wedge, (1.0 + 1e-12) * norm(forces[i])));
    const Vec3& carried_m = modes_.carried_m(p.id.mode);
    placed_.push_back({p, joint_.set().captured(i), forces[i], state_at(p, step.balance), carried_m});
    if (p.kind == PrimitiveKind::directed) step.directed_n += forces[i];
    if (placed_.back().state == PrimitiveState::stick) held_n += p.strength_n + norm(forces[i]);
    ledger.book(p.id.mode, forces[i], step.proxy_m - step.start_m, step.move_fraction * carried_m);
    furthest_carried_m = std::max(furthest_carried_m, norm(carried_m));
  }
  ledger.move(step.start_m, step.proxy_m, position_m, step.probe_m, step.move_fraction * furthest_carried_m);
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
  dropped_ += joint_.set().dropped();
  step.energy_before_j = energy_j(step.start_m);
  step.energy_after_j = energy_j(step.proxy_m);
  sub_steps_.push_back(step);
}

}  // namespace palpa
