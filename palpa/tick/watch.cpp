#include "palpa/tick/watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpa/field/roots.h"

namespace palpa {

namespace {
constexpr double never = 2.0;        // a share of the way beyond its end
constexpr double hair_share = 1e-9;  // of a sample spacing: changes are located to this, data gaps this short are rounding
constexpr double back_share = 0.25;  // of a sample spacing: within it a displaced proxy must be back on its side
constexpr double rounding = 1e-14;   // of a sample spacing: the first step beyond a root
constexpr int most_bisections = 60;
}  // namespace

Watches::Watches(std::span<const Watch> watches) {
  for (const Watch& watch : watches) {
    if (std::find(watches_.begin(), watches_.end(), watch) == watches_.end()) watches_.push_back(watch);
  }
  std::stable_sort(watches_.begin(), watches_.end(), [](const Watch& a, const Watch& b) { return a.field < b.field; });
  sides_.assign(watches_.size(), Side::none);
  attention_.assign(watches_.size(), Attention::stop);
  displaced_.assign(watches_.size(), 0);
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    FieldOnWay& field = on_way(watches_[i].field);
    if (field.first == field.last) field.first = i;
    field.last = i + 1;
  }
}

Watches::FieldOnWay& Watches::on_way(std::int32_t field) {
  for (FieldOnWay& known : fields_) {
    if (known.field == field) return known;
  }
  fields_.push_back({.field = field});
  return fields_.back();
}

void Watches::attend_edges(std::span<const std::int32_t> fields) {
  for (FieldOnWay& known : fields_) known.stops_at_edges = false;
  for (const std::int32_t field : fields) on_way(field).stops_at_edges = true;
}

bool Watches::is_watched(const Watch& watch) const noexcept {
  return std::find(watches_.begin(), watches_.end(), watch) != watches_.end();
}

void Watches::reset() noexcept { std::fill(sides_.begin(), sides_.end(), Side::none); }

Watches::Side Watches::side_at(Samples& samples, const Watch& watch) const noexcept {
  const ScalarSample& sample = samples.scalar(watch.field);
  if (!sample.inside) return Side::none;
  return sample.value >= watch.value ? Side::above : Side::below;
}

void Watches::look(Samples& samples) noexcept {
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    const Side side = side_at(samples, watches_[i]);
    if (side == Side::none || sides_[i] == Side::none) sides_[i] = side;
  }
}

void Watches::attend_all() noexcept {
  std::fill(attention_.begin(), attention_.end(), Attention::stop);
  for (FieldOnWay& known : fields_) known.carried_m = {};
}

void Watches::carry(std::int32_t field, const Vec3& carried_m) noexcept {
  for (FieldOnWay& known : fields_) {
    if (known.field == field) known.carried_m = carried_m;
  }
}

void Watches::take_side(const Watch& watch, bool above) noexcept {
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    if (watches_[i] == watch) sides_[i] = above ? Side::above : Side::below;
  }
}

void Watches::ignore(std::int32_t field) noexcept {
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    if (watches_[i].field == field) attention_[i] = Attention::held;
  }
}

void Watches::attend(const Watch& watch, Attention attention) noexcept {
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    // Of two planes on one level the one that holds decides.
    if (watches_[i] == watch && attention_[i] != Attention::held) attention_[i] = attention;
  }
}

void Watches::change(std::size_t watch, std::vector<Crossing>& crossings) noexcept {
  sides_[watch] = sides_[watch] == Side::below ? Side::above : Side::below;
  if (attention_[watch] != Attention::held) attention_[watch] = Attention::stop;
  crossings.push_back({watches_[watch].field, watches_[watch].value, sides_[watch] == Side::above});
}

// The next piece. Between the watched values on either side of the present one nothing happens.
void Watches::advance(FieldOnWay& at, Samples& samples) const noexcept {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Extent quiet{-infinity, infinity};
  bool all_known = at.has_data;
  for (std::size_t i = at.first; i < at.last; ++i) {
    if (attention_[i] == Attention::held) continue;
    if (sides_[i] == Side::above) quiet.min = std::max(quiet.min, watches_[i].value);
    if (sides_[i] == Side::below) quiet.max = std::min(quiet.max, watches_[i].value);
    all_known = all_known && sides_[i] != Side::none;
  }
  if (!all_known && at.first < at.last) quiet = {infinity, -infinity};
  at.piece = samples.stretch(at.field, at.way.start_m, at.way.end_m, at.begin, quiet);
  // Whatever a field answers, the search goes on.
  if (!(at.piece.end > at.begin)) at.piece.end = std::nextafter(at.begin, 2.0);
  at.piece.end = std::min(1.0, at.piece.end);
}

// Arrives on the piece: data may begin or end with it, and watched values may be passed on it.
void Watches::enter(FieldOnWay& at, Samples& samples) noexcept {
  at.event = never;
  at.at_edge = false;
  const bool short_gap = at.piece.end - at.begin <= at.hair && at.piece.end < 1.0;
  if (at.begins && !short_gap) at.has_data = at.piece.inside;
  const bool first = at.begins;
  if (!short_gap) at.begins = false;

  if (!at.piece.inside) {
    if (short_gap) return;
    if (at.has_data) stop_at_edge(at, samples);
    at.has_data = false;
    for (std::size_t i = at.first; i < at.last; ++i) sides_[i] = Side::none;
    return;
  }
  if (!at.has_data && !short_gap) {
    stop_at_edge(at, samples);
    at.has_data = true;
  }
  if (at.piece.degree < 0) return;
  for (std::size_t i = at.first; i < at.last; ++i) {
    const bool above = at.piece.control[0] >= watches_[i].value;
    if (sides_[i] == Side::none) {
      sides_[i] = above ? Side::above : Side::below;
    } else if (first && above != (sides_[i] == Side::above) && attention_[i] != Attention::held) {
      samples.move_to(at.way.at(std::min(1.0, back_share / hair_share * at.hair)));
      displaced_[i] = side_at(samples, watches_[i]) == sides_[i];
    }
  }
  if (!at.at_edge) search(at, 0.0, false, samples);
}

// Just beyond the edge, as samples see it.
void Watches::stop_at_edge(FieldOnWay& at, Samples& samples) const noexcept {
  if (!at.stops_at_edges) return;
  at.at_edge = true;
  at.event = at.begin;
  for (double step = std::max(rounding / hair_share * at.hair, at.way.rounding_share); step <= at.hair; step *= 8.0) {
    samples.move_to(at.way.at(at.event));
    if ((samples.scalar(at.field).inside || samples.vector(at.field).inside) == at.piece.inside) return;
    at.event = std::min(1.0, at.begin + step);
  }
}

// The first share of the piece, from `from` on, at which the watched value is passed. A displaced proxy has to be
// back on its side first.
double Watches::passage(const FieldOnWay& at, std::size_t watch, double from) noexcept {
  const bool up = sides_[watch] == Side::below;
  const double value = watches_[watch].value;
  if (displaced_[watch] != 0) {
    from = first_passage(at.piece.control, at.piece.degree, value, !up, from);
    if (from > 1.0) return never;
    displaced_[watch] = 0;
  }
  return first_passage(at.piece.control, at.piece.degree, value, up, from);
}

// Finds the first change of sides on the piece, from the share `from` of it on. `again`: what is passed right there was dealt
// with.
void Watches::search(FieldOnWay& at, double from, bool again, Samples& samples) noexcept {
  at.event = never;
  if (!at.piece.inside || at.piece.degree < 0) return;
  const auto [least, greatest] = std::minmax_element(at.piece.control, at.piece.control + at.piece.degree + 1);
  const double step = at.piece.end - at.begin;
  for (std::size_t i = at.first; i < at.last; ++i) {
    if (attention_[i] == Attention::held || sides_[i] == Side::none) continue;
    const bool up = sides_[i] == Side::below;
    const double value = watches_[i].value;
    if (displaced_[i] == 0 && (up ? *greatest < value : *least >= value)) continue;
    double start = from;
    if (again) {
      const double now = value_of(at.piece.control, at.piece.degree, start);
      if (up ? now >= value : now < value) displaced_[i] = 1;
    }
    while (start <= 1.0) {
      const double root = passage(at, i, start);
      if (root > 1.0) break;
      const double share = at.begin + root * step;
      if (share >= at.event) break;
      const double found = located(at, i, share, samples);
      if (found <= 1.0 && !is_rounding(at, i, found, samples)) {
        if (found < at.event) at.event = found, at.watch = i;
        break;
      }
      // Touched, for all that samples can tell.
      start = std::max(root + at.hair / step, std::nextafter(root, 2.0));
      displaced_[i] = 1;
    }
  }
}

// Whether a change where the way begins is undone a hair further on: of a proxy that stands on the level, rounding alone may
// see it on either side. Further on walls may be thinner than that.
bool Watches::is_rounding(const FieldOnWay& at, std::size_t watch, double share, Samples& samples) const noexcept {
  if (share > at.hair) return false;
  samples.move_to(at.way.at(std::min(1.0, share + at.hair)));
  return side_at(samples, watches_[watch]) == sides_[watch];
}

// The share just beyond a change at the root `share`, as samples see it; `never` where they see none. The polynomial is the
// interpolant to within rounding, or, of a formula, close to it.
double Watches::located(const FieldOnWay& at, std::size_t watch, double share, Samples& samples) const noexcept {
  const auto beyond = [&](double where) {
    samples.move_to(at.way.at(where));
    const Side side = side_at(samples, watches_[watch]);
    return side != Side::none && side != sides_[watch];
  };
  double near = share, far = never;
  double step = 0.0;
  for (double next = std::max(rounding / hair_share * at.hair, at.way.rounding_share); far > 1.0; next *= 8.0) {
    const double where = std::min(1.0, share + step);
    if (beyond(where)) {
      far = where;
    } else {
      near = where;
      if (where >= 1.0 || step >= at.hair) break;
      step = std::min(next, std::max(at.hair, at.way.rounding_share));
    }
  }
  if (far > 1.0) {
    // The formula's own root is further on, if it has any there.
    if (near >= at.piece.end || !beyond(at.piece.end)) return never;
    far = at.piece.end;
  } else if (far == share) {
    near = std::max(at.begin, share - at.hair);
    if (near >= share || !beyond(near)) return far;
    far = near;
    near = at.begin;
  } else {
    return far;
  }
  for (int i = 0; i < most_bisections && far - near > at.hair; ++i) {
    const double middle = 0.5 * (near + far);
    (beyond(middle) ? far : near) = middle;
  }
  return far;
}

// What else has changed at the stop: levels so close to one another that they are passed in one step.
void Watches::change_others(const FieldOnWay& at, Samples& samples, std::vector<Crossing>& crossings) noexcept {
  for (const FieldOnWay& field : fields_) {
    samples.move_to(field.way.at(at.event));
    for (std::size_t i = field.first; i < field.last; ++i) {
      if (i == at.watch || attention_[i] == Attention::held || sides_[i] == Side::none || displaced_[i] != 0) continue;
      const Side side = side_at(samples, watches_[i]);
      if (side != Side::none && side != sides_[i]) change(i, crossings);
    }
  }
  samples.move_to(at.way.at(at.event));
}

Watches::Met Watches::first_crossing(Samples& samples, const Vec3& start_m, const Vec3& end_m,
                                     std::vector<Crossing>& crossings) noexcept {
  if (fields_.empty()) return {};
  std::fill(displaced_.begin(), displaced_.end(), std::uint8_t{0});

  int left = most_stretches;
  const auto go_on = [&](FieldOnWay& at) {
    --left;
    advance(at, samples);
    enter(at, samples);
  };
  for (FieldOnWay& at : fields_) {
    Way& way = at.way;
    way = {start_m + at.carried_m, end_m, 0.0, 0.0};
    way.length_m = distance(way.start_m, end_m);
    if (at.first == at.last && !at.stops_at_edges) {
      at.event = never;
      at.piece.end = 1.0;
      continue;
    }
    at.begin = 0.0;
    at.begins = true;
    at.has_data = true;  // as long as nothing else is known
    at.event = never;
    at.piece = {};  // as long as the way, where that is none
    if (!(way.length_m > 0.0) || !std::isfinite(way.length_m)) continue;
    const double furthest_m = std::max(largest_component(way.start_m), largest_component(end_m));
    way.rounding_share = std::numeric_limits<double>::epsilon() * std::max(1.0, furthest_m / way.length_m);
    at.hair = hair_share * samples.spacing_m(at.field) / way.length_m;
    go_on(at);
  }

  while (true) {
    const auto next_of = [](const FieldOnWay& at) { return std::min(at.event, at.piece.end); };
    FieldOnWay& at = *std::min_element(fields_.begin(), fields_.end(),
                                       [&](const FieldOnWay& a, const FieldOnWay& b) { return next_of(a) < next_of(b); });
    if (at.event <= 1.0) {
      if (at.at_edge) return {at.event, true, true, false};
      const Attention passes = sides_[at.watch] == Side::below ? Attention::leave_up : Attention::leave_down;
      const bool stops = attention_[at.watch] != passes;
      change(at.watch, crossings);
      if (stops) {
        change_others(at, samples, crossings);
        return {at.event, true, false, false};
      }
      search(at, std::min(1.0, (at.event - at.begin) / (at.piece.end - at.begin)), true, samples);
      continue;
    }
    if (at.piece.end >= 1.0) return {};
    if (left <= 0) return {at.piece.end, true, false, true};
    at.begin = at.piece.end;
    go_on(at);
  }
}

double first_beyond(Samples& samples, std::int32_t field, double value, bool upwards, const Vec3& start_m,
                    const Vec3& end_m) noexcept {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Extent quiet = upwards ? Extent{-infinity, value} : Extent{value, infinity};
  double begin = 0.0;
  for (int i = 0; i < Watches::most_stretches && begin < 1.0; ++i) {
    const Stretch piece = samples.stretch(field, start_m, end_m, begin, quiet);
    const double end = std::min(1.0, std::max(piece.end, std::nextafter(begin, 2.0)));
    if (piece.inside && piece.degree >= 0) {
      const double root = first_passage(piece.control, piece.degree, value, upwards, 0.0);
      if (root <= 1.0) return std::min(1.0, begin + root * (end - begin));
    }
    begin = end;
  }
  return 1.0;
}

}  // namespace palpa
