#include "palpa/data/frame_shift.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "palpa/data/halton.h"
#include "palpa/data/timed_field.h"

namespace palpa {
namespace {

// Sample for the estimate: pairs of frames, places tried per pair, places used per pair (near the level, or the steepest
// tenth). More: slower; fewer: a less certain median and 90th percentile.
constexpr int most_pairs = 20;
constexpr int candidates = 20000;
constexpr std::size_t most_places = 500;
// Search along the gradient, in sample spacings. Longer reach: slower; shorter: far shifts count as lost. Longer step: thin
// edges are skipped; shorter: slower.
constexpr double reach_spacings = 32.0;
constexpr double step_spacings = 0.25;

struct Place {
  Vec3 at_m;
  ScalarSample sample;
};

/// Places within a spacing of the level, projected onto it; or the steepest tenth.
std::vector<Place> places_of(const Field& frame, std::optional<double> level) {
  const Box box = frame.bounds_m();
  std::vector<Place> places;
  for (int i = 1; i <= candidates; ++i) {
    Place place{detail::halton(i, box), {}};
    place.sample = frame.scalar(place.at_m);
    const double steepness = norm(place.sample.gradient);
    if (!place.sample.inside || !(steepness > 0.0)) continue;
    if (level) {
      const double way_m = (*level - place.sample.value) / steepness;
      if (!(std::abs(way_m) <= frame.spacing_m())) continue;
      place.at_m += way_m * normalized(place.sample.gradient);
      place.sample = frame.scalar(place.at_m);
      if (!place.sample.inside || !(norm(place.sample.gradient) > 0.0)) continue;
    }
    places.push_back(place);
  }
  const auto steeper = [](const Place& a, const Place& b) { return norm(a.sample.gradient) > norm(b.sample.gradient); };
  if (!level) {
    const std::size_t tenth = places.size() / 10;
    std::nth_element(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(tenth), places.end(), steeper);
    places.resize(tenth);
  }
  if (places.size() > most_places) places.resize(most_places);
  return places;
}

/// Width of the edge at a place [m]: its whole rise over its steepest slope.
double edge_width_m(const Field& frame, const Place& place, const Vec3& uphill) noexcept {
  const double h = frame.spacing_m(), steepness = norm(place.sample.gradient);
  double rise = 0.0, steepest = steepness;
  for (const double way : {1.0, -1.0}) {
    double last = place.sample.value;
    for (double d = step_spacings; d <= reach_spacings; d += step_spacings) {
      const ScalarSample s = frame.scalar(place.at_m + way * d * h * uphill);
      const double slope = dot(s.gradient, uphill);
      if (!s.inside || !(slope > 0.1 * steepness)) break;
      steepest = std::max(steepest, slope);
      last = s.value;
    }
    rise += std::abs(last - place.sample.value);
  }
  return rise / steepest;
}

/// Distance along the gradient to an equal value of the next frame, rising in this direction; infinity if none.
double shift_m(const Field& next, const Place& place, const Vec3& uphill) noexcept {
  const double h = next.spacing_m();
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const double way : {1.0, -1.0}) {
    ScalarSample before = next.scalar(place.at_m);
    for (double d = step_spacings; before.inside && d <= reach_spacings && (d - step_spacings) * h < nearest_m;
         d += step_spacings) {
      const ScalarSample s = next.scalar(place.at_m + way * d * h * uphill);
      if (!s.inside) break;
      const double from = before.value - place.sample.value, to = s.value - place.sample.value;
      const bool rises = way > 0.0 ? from <= 0.0 && to >= 0.0 : from >= 0.0 && to <= 0.0;
      if (rises && from != to) {
        nearest_m = std::min(nearest_m, (d - step_spacings + step_spacings * std::abs(from / (to - from))) * h);
        break;
      }
      before = s;
    }
  }
  return nearest_m;
}

}  // namespace

FrameShift frame_shift(const SeriesView& series, std::optional<double> level) {
  FrameShift result;
  const auto frames = static_cast<int>(series.frames.size());
  if (frames < 2 || series.frames.front()->components() != 1) return result;
  const int pairs = std::min(frames - 1, most_pairs);
  std::vector<double> shifts;
  for (int pair = 0; pair < pairs; ++pair) {
    const int first = pair * (frames - 1) / pairs;
    const Field& frame = *series.frames[static_cast<std::size_t>(first)];
    const Field& next = *series.frames[static_cast<std::size_t>(first) + 1];
    for (const Place& place : places_of(frame, level)) {
      const Vec3 uphill = normalized(place.sample.gradient);
      const double width_m = edge_width_m(frame, place, uphill);
      if (width_m > 0.0) shifts.push_back(shift_m(next, place, uphill) / width_m);
    }
  }
  if (shifts.empty()) return result;
  std::sort(shifts.begin(), shifts.end());
  result.places = static_cast<int>(shifts.size());
  result.median = shifts[shifts.size() / 2];
  result.p90 = shifts[shifts.size() * 9 / 10];
  result.lost_share = static_cast<double>(std::ranges::count_if(shifts, [](double s) { return std::isinf(s); })) /
                      static_cast<double>(shifts.size());
  return result;
}

}  // namespace palpa
