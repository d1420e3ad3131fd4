#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpa/data/halton.h"
#include "palpa/data/quantile.h"
#include "palpa/data/timed_field.h"

namespace palpa {
namespace {

/// (1 − u) a + u b, of values and derivatives.
ScalarSample blend(const ScalarSample& a, const ScalarSample& b, double u) noexcept {
  if (!a.inside || !b.inside) return {};
  return {(1.0 - u) * a.value + u * b.value, (1.0 - u) * a.gradient + u * b.gradient, true};
}
Mat3 blend(const Mat3& a, const Mat3& b, double u) noexcept {
  Mat3 m;
  for (int i = 0; i < 3; ++i) m.row[i] = (1.0 - u) * a.row[i] + u * b.row[i];
  return m;
}
VectorSample blend(const VectorSample& a, const VectorSample& b, double u) noexcept {
  if (!a.inside || !b.inside) return {};
  return {(1.0 - u) * a.value + u * b.value, blend(a.jacobian, b.jacobian, u), true};
}

/// Of a blend: data begin and end where those of a frame do. `largest`: of the frames' values, in the field's own unit.
LipschitzBound blend(const LipschitzBound& a, const LipschitzBound& b, double u, double largest) noexcept {
  const double radius_m = std::min(a.radius_m, b.radius_m);
  if (!(radius_m > 0.0)) return {};
  // [1] of the largest value: two products and a sum, of an interpolant that overshoots its samples by a few times.
  constexpr double of_blend = 64.0 * std::numeric_limits<double>::epsilon();
  const LipschitzBound blended{radius_m, (1.0 - u) * a.slope_per_m + u * b.slope_per_m,
                               (1.0 - u) * a.rounding + u * b.rounding + of_blend * largest};
  return std::isfinite(blended.slope_per_m + blended.rounding) ? blended : LipschitzBound{};
}

/// First part of a polynomial, as Bernstein coefficients over that part (P. de Casteljau).
void keep_first(PolynomialPiece& piece, double share) noexcept {
  for (int level = 1; level <= piece.degree; ++level) {
    for (int i = piece.degree; i >= level; --i) {
      piece.control[i] = (1.0 - share) * piece.control[i - 1] + share * piece.control[i];
    }
  }
}
/// Degree elevation.
void raise(PolynomialPiece& piece, int degree) noexcept {
  for (; piece.degree < degree; ++piece.degree) {
    const int n = piece.degree + 1;
    piece.control[n] = piece.control[n - 1];
    for (int i = n - 1; i > 0; --i) {
      const double share = static_cast<double>(i) / n;
      piece.control[i] = share * piece.control[i - 1] + (1.0 - share) * piece.control[i];
    }
  }
}

/// Noise of the gradient [unit/m], below which its direction is not used: three standard deviations of its components' noise,
/// from their median second difference between neighbours, which smooth data and (rare) edges hardly change.
double noise_of_gradient(const Field& field) {
  constexpr int places = 4096;  // [1] more: slower to load; fewer: a less certain median
  const Box box = field.bounds_m();
  const double h = field.spacing_m();
  std::vector<double> differences;
  for (int i = 1; i <= places; ++i) {
    const Vec3 at = detail::halton(i, box);
    const Vec3 step = i % 3 == 0 ? Vec3{h, 0, 0} : i % 3 == 1 ? Vec3{0, h, 0} : Vec3{0, 0, h};
    const ScalarSample here = field.scalar(at), ahead = field.scalar(at + step), behind = field.scalar(at - step);
    if (!here.inside || !ahead.inside || !behind.inside) continue;
    const Vec3 second = (ahead.gradient - here.gradient) - (here.gradient - behind.gradient);
    if (is_finite(second)) differences.insert(differences.end(), {std::abs(second.x), std::abs(second.y), std::abs(second.z)});
  }
  constexpr double median_of_normal = 0.6745;  // |x| of a standard normal variable
  // Of independent values a second difference has six times the variance of one.
  return 3.0 * detail::median(differences) / (median_of_normal * std::numbers::sqrt2 * std::numbers::sqrt3);
}

class FrameSeries final : public TimedField {
 public:
  FrameSeries(std::vector<FieldPtr> frames, double period_s, BetweenFrames between_frames)
      : view_{std::move(frames), period_s, between_frames}, extents_(view_.frames.front()->value_ranges()) {
    for (const FieldPtr& frame : view_.frames) {
      const std::vector<ValueRange> e = frame->value_ranges();
      for (std::size_t c = 0; c < e.size(); ++c) {
        extents_[c] = {std::min(extents_[c].min, e[c].min), std::max(extents_[c].max, e[c].max)};
      }
    }
    for (const ValueRange& e : extents_) largest_ = std::max({largest_, std::abs(e.min), std::abs(e.max)});
    if (components() == 1) noise_ = noise_of_gradient(first());
  }

  const SeriesView& view() const noexcept { return view_; }
  int components() const noexcept override { return first().components(); }
  int values_per_sample() const noexcept override {
    return (view_.between_frames == BetweenFrames::linear ? 2 : 1) * first().values_per_sample();
  }
  double spacing_m() const noexcept override { return first().spacing_m(); }
  double local_spacing_at(const Vec3& world_m, DataTime) const noexcept override { return first().local_spacing_m(world_m); }
  Box bounds_m() const noexcept override { return first().bounds_m(); }
  std::vector<ValueRange> value_ranges() const override { return extents_; }
  double cycle_s() const noexcept override { return static_cast<double>(view_.frames.size()) * view_.period_s; }
  double time_spacing_s() const noexcept override { return view_.period_s; }

  ScalarSample scalar_at(const Vec3& world_m, DataTime at) const noexcept override {
    const Between t = between(at);
    const ScalarSample a = view_.frames[t.a]->scalar(world_m);
    return t.u == 0.0 ? a : blend(a, view_.frames[t.b]->scalar(world_m), t.u);
  }
  VectorSample vector_at(const Vec3& world_m, DataTime at) const noexcept override {
    const Between t = between(at);
    const VectorSample a = view_.frames[t.a]->vector(world_m);
    return t.u == 0.0 ? a : blend(a, view_.frames[t.b]->vector(world_m), t.u);
  }
  Mat3 hessian_at(const Vec3& world_m, DataTime at) const noexcept override {
    const Between t = between(at);
    const Mat3 a = view_.frames[t.a]->hessian(world_m);
    if (t.u == 0.0) return a;
    // A place in only one of the two frames is outside, without a derivative.
    if (!scalar_at(world_m, at).inside) return {};
    return blend(a, view_.frames[t.b]->hessian(world_m), t.u);
  }
  LipschitzBound lipschitz_bound_at(const Vec3& world_m, DataTime at) const noexcept override {
    const Between t = between(at);
    const LipschitzBound a = view_.frames[t.a]->lipschitz_bound(world_m);
    if (t.u == 0.0 || a.radius_m == 0.0) return a;
    return blend(a, view_.frames[t.b]->lipschitz_bound(world_m), t.u, largest_);
  }
  double depth_at(const Vec3& world_m, DataTime at) const noexcept override {
    const Between t = between(at);
    const double a = view_.frames[t.a]->depth_m(world_m);
    return t.u == 0.0 ? a : std::min(a, view_.frames[t.b]->depth_m(world_m));
  }

  PolynomialPiece piece_along_at(const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet,
                                 DataTime at) const noexcept override {
    const Between t = between(at);
    const Field &one = *view_.frames[t.a], &other = *view_.frames[t.b];
    PolynomialPiece a = one.piece_along(from_m, to_m, begin, quiet);
    if (t.u == 0.0) return a;
    PolynomialPiece b = other.piece_along(from_m, to_m, begin, quiet);
    if (!a.inside || !b.inside) return {.end = !a.inside && !b.inside ? std::min(a.end, b.end) : !a.inside ? a.end : b.end};
    // Quiet in both frames implies quiet between them; else polynomials of both are requested.
    if (a.degree < 0 && b.degree < 0) return a.end <= b.end ? a : b;
    constexpr ValueRange never{1.0, -1.0};
    if (a.degree < 0) a = one.piece_along(from_m, to_m, begin, never);
    if (b.degree < 0) b = other.piece_along(from_m, to_m, begin, never);
    const double end = std::min(a.end, b.end);
    if (!a.inside || !b.inside || a.degree < 0 || b.degree < 0) return {.end = end};
    for (PolynomialPiece* piece : {&a, &b}) {
      if (piece->end > end) keep_first(*piece, (end - begin) / (piece->end - begin));
      raise(*piece, std::max(a.degree, b.degree));
    }
    for (int i = 0; i <= a.degree; ++i) a.control[i] = (1.0 - t.u) * a.control[i] + t.u * b.control[i];
    a.end = end;
    return a;
  }

  Carried carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept override {
    return components() == 1 ? carried_with_level(world_m, from, to, noise_) : Carried{world_m};
  }

 private:
  struct Between {
    std::size_t a = 0, b = 0;
    double u = 0.0;  ///< [1] share of b; 0: a alone
  };
  Between between(DataTime at) const noexcept {
    const std::size_t n = view_.frames.size();
    double x = at.within(cycle_s()) / view_.period_s;
    if (!at.loop) x = std::min(x, static_cast<double>(n - 1));
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
  const Field& first() const noexcept { return *view_.frames.front(); }

  SeriesView view_;
  std::vector<ValueRange> extents_;
  double largest_ = 0.0;  ///< of a component, the field's own unit
  double noise_ = 0.0;    ///< [unit/m] of a gradient
};

}  // namespace

const char* problem_with_frame(const Field& first, const Field& frame) noexcept {
  if (timed(frame)) return "changes with time itself; a frame must stay as it is";
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

const SeriesView* series_of(const Field& field) noexcept {
  const auto* series = dynamic_cast<const FrameSeries*>(&field);
  return series ? &series->view() : nullptr;
}

}  // namespace palpa
