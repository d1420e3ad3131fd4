#include "palpa/mode/crossings.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "palpa/data/roots.h"

namespace palpa {

namespace {
// [1] of a sample spacing: location error of crossings; shorter gaps in data are rounding. Less: rounding is reported as a
// crossing; more: crossings are located less precisely.
constexpr double hair_share = 1e-9;
// [1] of a sample spacing: a proxy that starts on the wrong side of a level must return within this. Less: a slight
// displacement counts as a crossing; more: a real crossing as a displacement.
constexpr double back_share = 0.25;
// [1] Pieces beyond its work budget that a search may use to get past rounding. More: longer worst tick; fewer: a crossing
// there is reported later, where the next search starts.
constexpr int most_within_rounding = 64;
constexpr double infinity = std::numeric_limits<double>::infinity();

bool is_before(const Threshold& a, const Threshold& b) noexcept {
  return a.field != b.field ? a.field < b.field : a.value < b.value;
}
}  // namespace

// Search for the first change of a field along the path, piece by piece.
struct Crossings::FieldOnWay {
  struct Change {
    double share = no_passage;  // [1] of the path
    Event::Kind kind = Event::Kind::none;
    std::int32_t field = -1;
    std::int32_t watch = -1;  // crossed
  };

  const Crossings& all_;
  const EventPolicy& policy_;
  Samples& samples_;
  const std::int32_t field_;
  const std::span<Side> sides_;
  const Vec3 start_m_, end_m_;  // shifted with the field's data
  // Rounding of positions, and `hair_share`, both as shares [1] of the path.
  const double length_m_ = distance(start_m_, end_m_);
  const double rounding_ = std::numeric_limits<double>::epsilon() *
                           std::max(1.0, std::max(largest_component(start_m_), largest_component(end_m_)) / length_m_);
  const double hair_ = hair_share * samples_.spacing_m(field_) / length_m_;
  double from_ = 0.0;   // [1] of the path
  double begin_ = 0.0;  // [1] of the path, start of the piece
  PolynomialPiece piece_{};
  std::int32_t displaced_ = -1;  // the value is beyond this watch, and returning

  Vec3 at(double share) const noexcept { return share < 1.0 ? start_m_ + share * (end_m_ - start_m_) : end_m_; }

  // First change from the share `from` of the path on; stored in `first` if it is earlier.
  void find(double from, int most_work, WorkBudget& budget, Change& first) noexcept {
    from_ = begin_ = from;
    bool begins = true, has_data = true;
    // Minimum progress of a search out of work. Far from the origin, where the whole path is within rounding, pieces have no
    // end.
    const double least = std::min(1.0, std::max(hair_, 2.0 * rounding_));
    const int of_piece = samples_.work_of_look(field_);
    for (int work = 0; begin_ < std::min(1.0, first.share); work += of_piece, begin_ = piece_.end) {
      if (work >= most_work + (begin_ > least ? 0 : most_within_rounding * of_piece)) {
        const double share = std::max(begin_, least);
        if (share < first.share) first = {share, Event::Kind::out_of_work, field_};
        return;
      }
      budget.spend(of_piece);
      // Between the adjacent watched values there is no event.
      piece_ = samples_.piece_along(field_, start_m_, end_m_, begin_, all_.quiet(policy_, field_, sides_));
      // A piece always has a length, whatever a field returns: the search makes progress.
      piece_.end = std::min(1.0, std::max(piece_.end, std::nextafter(begin_, 2.0)));
      const bool is_short = piece_.end - begin_ <= hair_ && piece_.end < 1.0;
      if (begins && !is_short) has_data = piece_.inside;
      if (!has_data) all_.forget(field_, sides_);
      if (piece_.inside != has_data) {
        if (is_short) continue;
        const auto shows_edge = [&](double share) {
          const Vec3 at_m = at(share);
          return (samples_.scalar(field_, at_m).inside || samples_.vector(field_, at_m).inside) == piece_.inside;
        };
        const bool stops = policy_.fields[field_].stops_at_edges;
        first = {stops ? just_beyond(begin_, shows_edge) : begin_, Event::Kind::edge, field_};
        return;
      }
      if (has_data && piece_.degree >= 0) {
        if (begins) set_out();
        search(first);
      }
      begins = begins && is_short;
    }
  }

  double value_of_watch(std::int32_t watch) const noexcept { return all_.watches_[watch].value; }
  bool is_above(std::int32_t watch) const noexcept { return sides_[watch] == Side::above; }

  // Whether a sample at a share of the path is on the other side of a watched value.
  bool is_beyond(std::int32_t watch, double share) const noexcept {
    const ScalarSample& sample = samples_.scalar(field_, at(share));
    return sample.inside && (sample.value >= value_of_watch(watch)) != is_above(watch);
  }

  // At the start of the path the value may be on a side other than the stored one.
  void set_out() noexcept {
    if (!all_.has_sides(field_, sides_)) {
      const ScalarSample& sample = samples_.scalar(field_, at(begin_));
      const double value = sample.inside ? sample.value : piece_.control[0];
      for (std::int32_t i = all_.ranges_[field_].first; i < all_.ranges_[field_].last; ++i)
        sides_[i] = value >= value_of_watch(i) ? Side::above : Side::below;
    }
    for (const bool up : {false, true}) {
      const std::int32_t watch = all_.border(policy_, field_, sides_, up);
      if (watch < 0 || (piece_.control[0] >= value_of_watch(watch)) != up) continue;
      const double back = std::min(1.0, from_ + back_share / hair_share * hair_);
      if (!is_beyond(watch, back) && samples_.scalar(field_, at(back)).inside) displaced_ = watch;
    }
  }

  // First point from `share` on, up to `hair_` beyond, whose samples show the change; else the last point.
  template <class Shows>
  double just_beyond(double share, Shows&& shows) const noexcept {
    double at = share;
    for (double step = rounding_; !shows(at); step *= 8.0) {
      const double next = std::min(1.0, share + std::min(step, std::max(hair_, rounding_)));
      if (next == at) break;
      at = next;
    }
    return at;
  }

  void search(Change& first) noexcept {
    const ValueRange& allowed = policy_.fields[field_].allowed;
    for (const bool up : {false, true}) {
      const double root = first_passage(piece_.control, piece_.degree, up ? allowed.max : allowed.min, up);
      const double depth = std::min(1.0, begin_ + root * (piece_.end - begin_));
      if (root <= 1.0 && depth < first.share) first = {depth, Event::Kind::pierced, field_};
      const std::int32_t watch = all_.border(policy_, field_, sides_, up);
      const double share = watch >= 0 ? passage(watch, up, first.share) : no_passage;
      if (share < first.share) first = {share, Event::Kind::crossing, field_, watch};
    }
  }

  // Share of the path just beyond the first crossing of a watched value on the piece; `no_passage` if there is none before the
  // share `before`.
  double passage(std::int32_t watch, bool up, double before) noexcept {
    const double value = value_of_watch(watch);
    const double length = piece_.end - begin_;
    const auto is_across = [&](double control) { return (control >= value) == up; };
    const double* end = piece_.control + piece_.degree + 1;
    if (displaced_ != watch && std::none_of<const double*>(piece_.control, end, is_across)) return no_passage;
    double root = 0.0;
    while (root <= 1.0) {
      if (displaced_ == watch) {  // must return to its side first
        root = first_passage(piece_.control, piece_.degree, value, !up, root);
        if (root > 1.0) break;
        displaced_ = -1;
      }
      root = first_passage(piece_.control, piece_.degree, value, up, root);
      const double share = begin_ + root * length;
      if (root > 1.0 || share >= before) break;
      const double found = located(watch, share);
      // At its start, a proxy on the level may be sampled on either side, by rounding alone. Further on walls may be thinner
      // than that.
      const bool is_rounding = found <= from_ + hair_ && !is_beyond(watch, std::min(1.0, found + hair_));
      if (found <= 1.0 && !is_rounding) return found;
      // Touched, as far as samples can resolve.
      root = std::max(root + hair_ / length, std::nextafter(root, 2.0));
      displaced_ = watch;
    }
    return no_passage;
  }

  // Share just beyond the sampled change near the root `share`; `no_passage` without one. The polynomial is the interpolant to
  // within rounding, or, for a formula, close to it.
  double located(std::int32_t watch, double share) const noexcept {
    const auto shows = [&](double there) { return is_beyond(watch, there); };
    double near = begin_, far = std::max(begin_, share - hair_);
    if (!shows(far)) {  // else the formula's own root is earlier
      near = just_beyond(share, shows);
      if (shows(near)) return near;
      far = piece_.end;  // or later on the piece, if at all
      if (far <= near || !shows(far)) return no_passage;
    }
    while (far - near > std::max(hair_, rounding_)) {
      const double middle = 0.5 * (near + far);
      (shows(middle) ? far : near) = middle;
    }
    return far;
  }
};

void EventPolicy::clear() noexcept {
  std::fill(passing.begin(), passing.end(), CrossingRule::stops);
  std::fill(fields.begin(), fields.end(), OfField{.allowed = {-infinity, infinity}});
}

Crossings::Crossings(StateArena& live, std::span<const Threshold> watches, std::size_t fields, std::size_t feet)
    : ranges_(fields) {
  for (const Threshold& watch : watches) {
    if (watch.field >= 0 && watch.field < static_cast<std::int64_t>(fields) && !std::isnan(watch.value))
      watches_.push_back(watch);
  }
  std::stable_sort(watches_.begin(), watches_.end(), is_before);
  watches_.erase(std::unique(watches_.begin(), watches_.end()), watches_.end());
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(watches_.size()); ++i) {
    Range& range = ranges_[watches_[i].field];
    if (range.last == 0) range.first = i;
    range.last = i + 1;
  }
  sides_ = live.add<Side>(feet * watches_.size());
}

EventPolicy Crossings::policy() const {
  EventPolicy policy;
  policy.passing.resize(watches_.size());
  policy.fields.resize(ranges_.size());
  policy.clear();
  return policy;
}

Event Crossings::event() const {
  Event event;
  event.crossings.reserve(2 * watches_.size());
  event.balls_.resize(ranges_.size());
  event.sides_.resize(watches_.size());
  event.on_way_.reserve(ranges_.size());
  return event;
}

std::int32_t Crossings::index_of(const Threshold& watch) const noexcept {
  if (watch.field < 0 || static_cast<std::size_t>(watch.field) >= ranges_.size()) return -1;
  const auto [first, last] = ranges_[watch.field];
  const auto of_field = std::span(watches_).subspan(first, last - first);
  const auto found = std::ranges::lower_bound(of_field, watch.value, {}, &Threshold::value);
  return found != of_field.end() && found->value == watch.value ? first + static_cast<std::int32_t>(found - of_field.begin())
                                                                : -1;
}

bool Crossings::has_sides(std::int32_t field, std::span<const Side> sides) const noexcept {
  return ranges_[field].first < ranges_[field].last && sides[ranges_[field].first] != Side::none;
}

void Crossings::forget(std::int32_t field, std::span<Side> sides) const noexcept {
  std::fill(sides.begin() + ranges_[field].first, sides.begin() + ranges_[field].last, Side::none);
}

void Crossings::configure_events(EventPolicy& policy, const Threshold& watch,
                                 EventPolicy::CrossingRule passing) const noexcept {
  const std::int32_t i = index_of(watch);
  if (i >= 0 && policy.passing[i] != EventPolicy::CrossingRule::held) policy.passing[i] = passing;
}

void Crossings::reset() noexcept { std::fill(sides_.begin(), sides_.end(), Side::none); }

void Crossings::take_side(std::size_t foot, const Threshold& watch, bool above) noexcept {
  const std::int32_t i = index_of(watch);
  const std::span<Side> sides = sides_of(foot);
  if (i >= 0 && sides[i] != Side::none) sides[i] = above ? Side::above : Side::below;
}

// Next watch of a field upwards or downwards; -1 if there is none. Of many watches the system's byte search skips dozens at
// once; of a few a call takes longer than they do.
std::int32_t Crossings::border(const EventPolicy& policy, std::int32_t field, std::span<const Side> sides,
                               bool up) const noexcept {
  constexpr std::int32_t few = 16;
  const auto [first, last] = ranges_[field];
  if (policy.fields[field].is_ignored) return -1;
  const Side side = up ? Side::below : Side::above;
  const auto borders = [&](std::int32_t at) { return policy.passing[at] != EventPolicy::CrossingRule::held; };
  if (last - first <= few) {
    for (std::int32_t n = 0; n < last - first; ++n) {
      const std::int32_t at = up ? first + n : last - 1 - n;
      if (sides[at] == side && borders(at)) return at;
    }
    return -1;
  }
  for (std::span<const Side> left = sides.subspan(first, last - first); !left.empty();) {
    const void* const found = up ? std::memchr(left.data(), static_cast<int>(side), left.size())
                                 : ::memrchr(left.data(), static_cast<int>(side), left.size());
    if (!found) return -1;
    const auto at = static_cast<std::int32_t>(static_cast<const Side*>(found) - sides.data());
    if (borders(at)) return at;
    left = up ? sides.subspan(at + 1, last - at - 1) : sides.subspan(first, at - first);
  }
  return -1;
}

// Range of a field's values without an event; empty if unknown.
ValueRange Crossings::quiet(const EventPolicy& policy, std::int32_t field, std::span<const Side> sides) const noexcept {
  ValueRange quiet = policy.fields[field].allowed;
  if (ranges_[field].first == ranges_[field].last) return quiet;
  if (!has_sides(field, sides)) return {infinity, -infinity};
  if (const std::int32_t below = border(policy, field, sides, false); below >= 0)
    quiet.min = std::max(quiet.min, watches_[below].value);
  if (const std::int32_t above = border(policy, field, sides, true); above >= 0)
    quiet.max = std::min(quiet.max, watches_[above].value);
  return quiet;
}

// Whether the path lies so near to a known value, its tangent, or the chord of the values at both ends that no event is
// possible.
bool Crossings::is_safe(std::int32_t field, std::span<const Side> sides, const Vec3& start_m, const Vec3& end_m,
                        const EventPolicy& policy, Samples& samples, Event& event) const noexcept {
  const ValueRange quiet = this->quiet(policy, field, sides);
  const bool is_any_value = quiet.min == -infinity && quiet.max == infinity;
  Event::Ball& ball = event.balls_[field];
  const std::uint64_t moment = samples.moment_of(field);
  const auto is_near_center = [&](double reach_m) {
    const LipschitzBound& bound = ball.lipschitz_bound;
    if (!(reach_m < bound.radius_m) || ball.moment != moment) return false;
    if (!ball.inside) return !has_sides(field, sides);
    // Where a field is constant, also on a watched value.
    if (is_any_value || (bound.values.min >= quiet.min && bound.values.max < quiet.max)) return true;
    const double change = bound.change(reach_m);
    if (ball.value - change > quiet.min && ball.value + change < quiet.max) return true;
    // Along a level the value changes far less than the slope allows.
    const double off = bound.off_tangent(reach_m);
    const auto is_within = [&](double value) { return value - off > quiet.min && value + off < quiet.max; };
    return is_within(ball.value + dot(ball.gradient, start_m - ball.center_m)) &&
           is_within(ball.value + dot(ball.gradient, end_m - ball.center_m));
  };
  // A value leaves the chord of two by a quarter of its distance from the tangent of one.
  const auto is_near_chord = [&](double reach_m) {
    const LipschitzBound& bound = ball.lipschitz_bound;
    if (!(reach_m < bound.radius_m) || ball.moment != moment || !ball.inside) return false;
    const double off = bound.off_chord(distance(start_m, end_m));
    const auto is_within = [&](const Vec3& at_m) {
      const ScalarSample& at = samples.scalar(field, at_m);
      return at.inside && at.value - off > quiet.min && at.value + off < quiet.max;
    };
    return quiet.max - quiet.min > 2.0 * off && is_within(start_m) && is_within(end_m);
  };
  const double reach_m = std::max(distance(start_m, ball.center_m), distance(end_m, ball.center_m));
  if (is_near_center(reach_m)) return true;
  // The end of a way on a level that holds is sampled in any case.
  const bool is_held = policy.fields[field].allowed != ValueRange{-infinity, infinity};
  if (is_held && is_near_chord(reach_m)) return true;
  const ScalarSample& sample = samples.scalar(field, start_m);
  const bool inside = sample.inside || samples.vector(field, start_m).inside;
  ball = {start_m, moment, sample.value, sample.gradient, inside, samples.lipschitz_bound(field, start_m)};
  const double length_m = distance(start_m, end_m);
  return is_near_center(length_m) || is_near_chord(length_m);
}

void Crossings::first_event(std::size_t foot, const Vec3& start_m, const Vec3& end_m, const EventPolicy& policy,
                            Samples& samples, WorkBudget& work, Event& event) const noexcept {
  const std::span<const Side> sides = sides_of(foot);
  event.clear();
  const auto on_way = [&](std::int32_t field) {
    const Vec3 from_m = start_m + policy.fields[field].carried_m;
    return FieldOnWay{*this, policy, samples, field, event.sides_, from_m, end_m};
  };
  const double way_m = distance(start_m, end_m);
  for (std::int32_t field = 0; field < static_cast<std::int32_t>(ranges_.size()); ++field) {
    const EventPolicy::OfField& of = policy.fields[field];
    if (ranges_[field].first == ranges_[field].last && !of.stops_at_edges && of.allowed == ValueRange{-infinity, infinity})
      continue;
    const Vec3 from_m = start_m + of.carried_m;
    const double length_m = of.carried_m == Vec3{} ? way_m : distance(from_m, end_m);
    if (!(length_m > 0.0) || !std::isfinite(length_m)) continue;
    if (!is_safe(field, sides, from_m, end_m, policy, samples, event)) event.on_way_.push_back(field);
  }
  if (event.on_way_.empty()) return;
  event.share = 0.0;
  std::ranges::copy(sides, event.sides_.begin());
  const auto cross = [&](std::int32_t watch, bool up) {
    event.sides_[watch] = up ? Side::above : Side::below;
    if (event.crossings.size() < event.crossings.capacity())
      event.crossings.push_back({watches_[watch].field, watches_[watch].value, up});
  };
  // Continues beyond changes that do not stop the path.
  while (event.kind == Event::Kind::none) {
    FieldOnWay::Change first;
    int fields_left = static_cast<int>(event.on_way_.size());
    for (const std::int32_t field : event.on_way_) {
      on_way(field).find(event.share, work.left() / fields_left--, work, first);
    }
    event.share = std::min(1.0, first.share);
    if (first.kind == Event::Kind::none) break;
    if (first.kind == Event::Kind::edge) forget(first.field, event.sides_);
    if (first.kind == Event::Kind::edge && !policy.fields[first.field].stops_at_edges) continue;
    if (first.kind == Event::Kind::crossing) {
      const bool up = event.sides_[first.watch] == Side::below;
      cross(first.watch, up);
      using CrossingRule = EventPolicy::CrossingRule;
      const CrossingRule passing = policy.passing[first.watch];
      if (passing == CrossingRule::passes || passing == (up ? CrossingRule::leaves_up : CrossingRule::leaves_down)) continue;
      // Close levels may be crossed in a single step.
      std::int32_t next = border(policy, first.field, event.sides_, up);
      for (; next >= 0 && on_way(first.field).is_beyond(next, event.share);
           next = border(policy, first.field, event.sides_, up))
        cross(next, up);
    }
    event.kind = first.kind;
  }
}

}  // namespace palpa
