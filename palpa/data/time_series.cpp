#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpa/data/blend.h"
#include "palpa/data/field_at_moment.h"
#include "palpa/data/halton.h"
#include "palpa/data/octave_parts.h"

namespace palpa {
namespace {

class FrameSeries final : public FieldOfMoments {
 public:
  FrameSeries(std::vector<FieldPtr> frames, double period_s, BetweenFrames between_frames)
      : view_{std::move(frames), period_s, between_frames},
        octaves_(octaves_of(first())),
        extents_(view_.frames.front()->value_ranges()) {
    for (const FieldPtr& frame : view_.frames) {
      const std::vector<ValueRange> e = frame->value_ranges();
      for (std::size_t c = 0; c < e.size(); ++c) {
        extents_[c] = {std::min(extents_[c].min, e[c].min), std::max(extents_[c].max, e[c].max)};
      }
    }
    for (const ValueRange& e : extents_) largest_ = std::max({largest_, std::abs(e.min), std::abs(e.max)});
    if (components() == 1) noise_ = noise_of_frames();
  }

  const SeriesView& view() const noexcept { return view_; }
  int components() const noexcept override { return first().components(); }
  int values_per_sample() const noexcept override {
    return (view_.between_frames == BetweenFrames::linear ? 2 : 1) * first().values_per_sample();
  }
  double spacing_m() const noexcept override { return first().spacing_m(); }
  Box bounds_m() const noexcept override { return first().bounds_m(); }
  std::vector<ValueRange> value_ranges() const override { return extents_; }
  double cycle_s() const noexcept override { return static_cast<double>(view_.frames.size()) * view_.period_s; }
  double time_spacing_s() const noexcept override { return view_.period_s; }

  FieldAtMoment at_moment(DataTime at) const noexcept override {
    const Between t = between(at);
    const Field &a = *view_.frames[t.a], &b = *view_.frames[t.b];
    if (!octaves_) return t.u == 0.0 ? FieldAtMoment(a) : FieldAtMoment(a, b, t.u, largest_);
    return t.u == 0.0 ? FieldAtMoment(octaves(t.a), at) : FieldAtMoment(octaves(t.a), octaves(t.b), t.u, largest_, at);
  }

  Carried carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept override {
    const Between end = between(to);
    if (components() != 1 || (between(from) == end && (!octaves_ || from.octave == to.octave))) return {world_m};
    if (!octaves_ || to.octave < 1.0) return carried_with_level(world_m, from, to, noise_);
    const Octaves& later = octaves(end.a);
    return later.is_felt(to) ? carried_with_level(world_m, from, to, later.noise_at(to)) : Carried{world_m};
  }

 private:
  struct Between {
    std::size_t a = 0, b = 0;
    double u = 0.0;  ///< [1] share of b; 0: a alone
    friend bool operator==(const Between&, const Between&) = default;
  };
  Between between(DataTime at) const noexcept {
    const std::size_t n = view_.frames.size();
    double x = frame_at(view_, at);
    const double nearest = std::round(x);
    // i · period / period may be off by a rounding, but must give that frame.
    if (view_.between_frames == BetweenFrames::nearest || std::abs(x - nearest) <= 1e-12 * nearest) x = nearest;
    Between t;
    const double whole = std::floor(x);
    t.a = static_cast<std::size_t>(whole) % n;
    t.b = (t.a + 1) % n;
    t.u = x - whole;
    return t;
  }
  double noise_of_frames() const {
    constexpr int places = 4096;  // [1] more: slower to load; fewer: a less certain median
    const Box box = bounds_m();
    const auto place = [&](int i) { return detail::halton(i, box); };
    return octaves_ ? octaves_->noise_of_finest(places, place) : detail::noise_of_gradient(first(), places, place);
  }
  const Octaves& octaves(std::size_t frame) const noexcept { return static_cast<const Octaves&>(*view_.frames[frame]); }
  const Field& first() const noexcept { return *view_.frames.front(); }

  SeriesView view_;
  const Octaves* octaves_;  ///< the first frame, if all are octaves
  std::vector<ValueRange> extents_;
  double largest_ = 0.0;  ///< of a component, the field's own unit
  double noise_ = 0.0;    ///< [unit/m] of a gradient
};

}  // namespace

const char* problem_with_frame(const Field& first, const Field& frame) noexcept {
  const Octaves *whole = octaves_of(first), *next = octaves_of(frame);
  if (whole && !(next && whole->count() == next->count())) return "is not in as many octaves as the first";
  if (!whole && timed(frame)) return "changes with time itself; a frame must stay as it is";
  if (frame.components() != first.components()) return "has another number of components than the first; all must be alike";
  const Box a = first.bounds_m(), b = frame.bounds_m();
  const double spacing_m = first.spacing_m(), close_m = 1e-3 * spacing_m;
  if (std::abs(frame.spacing_m() - spacing_m) > 1e-6 * spacing_m || !(largest_component(a.low_m - b.low_m) <= close_m) ||
      !(largest_component(a.high_m - b.high_m) <= close_m)) {
    return "lies on another grid than the first; all frames must have one geometry";
  }
  return nullptr;
}

FieldPtr time_series(std::vector<FieldPtr> frames, double period_s, BetweenFrames between_frames) {
  if (frames.empty()) throw std::invalid_argument("a time series needs at least one frame");
  if (!(period_s > 0.0) || !std::isfinite(period_s * static_cast<double>(frames.size()))) {
    throw std::invalid_argument("the time from frame to frame must be above 0 and finite");
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string the = "frame " + std::to_string(i) + " of the time series ";
    if (!frames[i]) throw std::invalid_argument(the + "is no field");
    if (const char* problem = problem_with_frame(*frames.front(), *frames[i])) throw std::invalid_argument(the + problem);
  }
  return std::make_shared<const FrameSeries>(std::move(frames), period_s, between_frames);
}

double frame_at(const SeriesView& series, DataTime at) noexcept {
  const auto frames = static_cast<double>(series.frames.size());
  const double position = at.within(frames * series.period_s) / series.period_s;
  return at.loop ? position : std::min(position, frames - 1.0);
}

const SeriesView* series_of(const Field& field) noexcept {
  const auto* series = dynamic_cast<const FrameSeries*>(&field);
  return series ? &series->view() : nullptr;
}

}  // namespace palpa
