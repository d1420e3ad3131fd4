#include "palpa/field/timed_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpa/field/grid.h"
#include "palpa/field/halton.h"

namespace palpa {
namespace {

constexpr double half_turn = std::numbers::pi;  // [rad]

/// A timed field at one moment, for as long as that field is there.
class Moment : public Field {
 public:
  Moment(const TimedField& field, DataTime at) noexcept : field_(field), at_(at) {}
  int components() const noexcept override { return field_.components(); }
  ScalarSample scalar(const Vec3& world_m) const noexcept override { return field_.scalar_at(world_m, at_); }
  VectorSample vector(const Vec3& world_m) const noexcept override { return field_.vector_at(world_m, at_); }
  double spacing_m() const noexcept override { return field_.spacing_m(); }
  Box bounds_m() const noexcept override { return field_.bounds_m(); }
  double depth_m(const Vec3& world_m) const noexcept override { return field_.depth_at(world_m, at_); }
  std::vector<Extent> extents() const override { return field_.extents(); }

 protected:
  const TimedField& field_;
  DataTime at_;
};

/// The same, which keeps the field.
class Frozen final : public Moment {
 public:
  Frozen(FieldPtr field, DataTime at) : Moment(*timed(*field), at), kept_(std::move(field)) {}
  Mat3 hessian(const Vec3& world_m) const noexcept override { return field_.hessian_at(world_m, at_); }
  Stretch stretch(const Vec3& from_m, const Vec3& to_m, double begin, const Extent& quiet) const noexcept override {
    return field_.stretch_at(from_m, to_m, begin, quiet, at_);
  }

 private:
  FieldPtr kept_;
};

// ---- Series

/// (1 − u) a + u b, each derivative with its value.
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

/// The first part of a polynomial, as Bernstein coefficients over that part alone (P. de Casteljau).
void keep_first(Stretch& piece, double share) noexcept {
  for (int level = 1; level <= piece.degree; ++level) {
    for (int i = piece.degree; i >= level; --i) {
      piece.control[i] = (1.0 - share) * piece.control[i - 1] + share * piece.control[i];
    }
  }
}
/// The same polynomial with the coefficients of a higher degree.
void raise(Stretch& piece, int degree) noexcept {
  for (; piece.degree < degree; ++piece.degree) {
    const int n = piece.degree + 1;
    piece.control[n] = piece.control[n - 1];
    for (int i = n - 1; i > 0; --i) {
      const double share = static_cast<double>(i) / n;
      piece.control[i] = share * piece.control[i - 1] + (1.0 - share) * piece.control[i];
    }
  }
}

/// Below this a gradient [unit/m] says nothing: three standard deviations of the noise of its components, as told by their
/// median second difference from neighbour to neighbour, which smooth data and edges, being rare, hardly move.
double noise_of_gradient(const Field& field) {
  constexpr int places = 4096;
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
  if (differences.empty()) return 0.0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  constexpr double median_of_normal = 0.6745;  // |x| of a standard normal variable
  // Of independent values a second difference has six times the variance of one.
  return 3.0 * *middle / (median_of_normal * std::numbers::sqrt2 * std::numbers::sqrt3);
}

class Series final : public TimedField {
 public:
  Series(std::vector<FieldPtr> frames, double period_s, BetweenFrames between_frames)
      : view_{std::move(frames), period_s, between_frames}, extents_(view_.frames.front()->extents()) {
    for (const FieldPtr& frame : view_.frames) {
      const std::vector<Extent> e = frame->extents();
      for (std::size_t c = 0; c < e.size(); ++c) {
        extents_[c] = {std::min(extents_[c].min, e[c].min), std::max(extents_[c].max, e[c].max)};
      }
    }
    if (components() == 1) noise_ = noise_of_gradient(first());
  }

  const SeriesView& view() const noexcept { return view_; }
  int components() const noexcept override { return first().components(); }
  double spacing_m() const noexcept override { return first().spacing_m(); }
  double local_spacing_m(const Vec3& world_m) const noexcept override { return first().local_spacing_m(world_m); }
  Box bounds_m() const noexcept override { return first().bounds_m(); }
  std::vector<Extent> extents() const override { return extents_; }
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
    // A place that only one of the two has is outside, and has no derivative.
    if (!scalar_at(world_m, at).inside) return {};
    return blend(a, view_.frames[t.b]->hessian(world_m), t.u);
  }
  double depth_at(const Vec3& world_m, DataTime at) const noexcept override {
    const Between t = between(at);
    const double a = view_.frames[t.a]->depth_m(world_m);
    return t.u == 0.0 ? a : std::min(a, view_.frames[t.b]->depth_m(world_m));
  }

  Stretch stretch_at(const Vec3& from_m, const Vec3& to_m, double begin, const Extent& quiet,
                     DataTime at) const noexcept override {
    const Between t = between(at);
    const Field &one = *view_.frames[t.a], &other = *view_.frames[t.b];
    Stretch a = one.stretch(from_m, to_m, begin, quiet);
    if (t.u == 0.0) return a;
    Stretch b = other.stretch(from_m, to_m, begin, quiet);
    if (!a.inside || !b.inside) return {.end = !a.inside && !b.inside ? std::min(a.end, b.end) : !a.inside ? a.end : b.end};
    // What stays in the quiet interval in both frames does so between them; else both are asked for polynomials.
    if (a.degree < 0 && b.degree < 0) return a.end <= b.end ? a : b;
    constexpr Extent never{1.0, -1.0};
    if (a.degree < 0) a = one.stretch(from_m, to_m, begin, never);
    if (b.degree < 0) b = other.stretch(from_m, to_m, begin, never);
    const double end = std::min(a.end, b.end);
    if (!a.inside || !b.inside || a.degree < 0 || b.degree < 0) return {.end = end};
    for (Stretch* piece : {&a, &b}) {
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
    // i · period / period may be off by a rounding, and a frame is to be that frame.
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
  std::vector<Extent> extents_;
  double noise_ = 0.0;  ///< [unit/m] of a gradient
};

// ---- Poses

/// The rotation about `axis`, a unit vector, by an angle [rad] (O. Rodrigues, 1840).
Mat3 rotation_about(const Vec3& axis, double angle) noexcept {
  const double c = std::cos(angle), s = std::sin(angle), v = 1.0 - c;
  return {{{c + v * axis.x * axis.x, v * axis.x * axis.y - s * axis.z, v * axis.x * axis.z + s * axis.y},
           {v * axis.y * axis.x + s * axis.z, c + v * axis.y * axis.y, v * axis.y * axis.z - s * axis.x},
           {v * axis.z * axis.x - s * axis.y, v * axis.z * axis.y + s * axis.x, c + v * axis.z * axis.z}}};
}

/// The way from one rotation to another: R₁ = turn · R₀, about an axis of the world.
struct Turn {
  Vec3 axis;           ///< unit, or zero where there is no turn
  double angle = 0.0;  ///< [rad] 0…π
};
Turn turn_between(const Mat3& from, const Mat3& to) noexcept {
  const Mat3 r = to * transposed(from);
  const Vec3 twice_sine{r.row[2].y - r.row[1].z, r.row[0].z - r.row[2].x, r.row[1].x - r.row[0].y};
  const double twice_cosine = r.row[0].x + r.row[1].y + r.row[2].z - 1.0;
  return {normalized(twice_sine), std::atan2(norm(twice_sine), twice_cosine)};
}

class Moving final : public TimedField {
 public:
  Moving(FieldPtr field, PoseTrack track, int per_length)
      : view_{std::move(field), std::move(track), per_length}, timed_(timed(*view_.field)) {
    find_bounds();
    for (const TimedPose& key : view_.track) {
      least_scale_ = std::min(least_scale_, key.pose.scale);
      largest_scale_ = std::max(largest_scale_, key.pose.scale);
    }
  }

  const MovingView& view() const noexcept { return view_; }
  int components() const noexcept override { return view_.field->components(); }
  double spacing_m() const noexcept override { return least_scale_ * view_.field->spacing_m(); }
  Box bounds_m() const noexcept override { return bounds_m_; }
  double cycle_s() const noexcept override {
    return std::max(timed_ ? timed_->cycle_s() : 0.0, view_.track.size() > 1 ? view_.track.back().time_s : 0.0);
  }
  double time_spacing_s() const noexcept override {
    double least_s = timed_ ? timed_->time_spacing_s() : std::numeric_limits<double>::max();
    for (std::size_t i = 1; i < view_.track.size(); ++i) {
      least_s = std::min(least_s, view_.track[i].time_s - view_.track[i - 1].time_s);
    }
    return least_s;
  }

  ScalarSample scalar_at(const Vec3& world_m, DataTime at) const noexcept override {
    const Similarity pose = pose_at(view_.track, at);
    const Vec3 local_m = pose.to_hand(world_m);
    ScalarSample s = timed_ ? timed_->scalar_at(local_m, at) : view_.field->scalar(local_m);
    s.value = per_length(s.value, pose);
    s.gradient = pose.rotation * s.gradient / pose.scale;
    for (int n = 0; n < view_.per_length; ++n) s.gradient = s.gradient / pose.scale;
    return std::isfinite(s.value) && is_finite(s.gradient) ? s : ScalarSample{};
  }

  VectorSample vector_at(const Vec3& world_m, DataTime at) const noexcept override {
    const Similarity pose = pose_at(view_.track, at);
    const Vec3 local_m = pose.to_hand(world_m);
    VectorSample s = timed_ ? timed_->vector_at(local_m, at) : view_.field->vector(local_m);
    s.value = pose.rotation * s.value;
    s.jacobian = pose.rotation * s.jacobian * transposed(pose.rotation);
    for (Vec3& row : s.jacobian.row) row = row / pose.scale;
    for (int n = 0; n < view_.per_length; ++n) {
      s.value = s.value / pose.scale;
      for (Vec3& row : s.jacobian.row) row = row / pose.scale;
    }
    return is_finite(s.value) && is_finite(s.jacobian) ? s : VectorSample{};
  }

  Mat3 hessian_at(const Vec3& world_m, DataTime at) const noexcept override {
    const Similarity pose = pose_at(view_.track, at);
    const Vec3 local_m = pose.to_hand(world_m);
    Mat3 h =
        pose.rotation * (timed_ ? timed_->hessian_at(local_m, at) : view_.field->hessian(local_m)) * transposed(pose.rotation);
    for (Vec3& row : h.row) {
      row = row / pose.scale / pose.scale;
      for (int n = 0; n < view_.per_length; ++n) row = row / pose.scale;
    }
    return is_finite(h) ? h : Mat3{};
  }

  double depth_at(const Vec3& world_m, DataTime at) const noexcept override {
    const Similarity pose = pose_at(view_.track, at);
    const Vec3 local_m = pose.to_hand(world_m);
    const double depth = pose.scale * (timed_ ? timed_->depth_at(local_m, at) : view_.field->depth_m(local_m));
    return std::isfinite(depth) ? depth : 0.0;
  }

  Stretch stretch_at(const Vec3& from_m, const Vec3& to_m, double begin, const Extent& quiet,
                     DataTime at) const noexcept override {
    const Similarity pose = pose_at(view_.track, at);
    const Vec3 from_local_m = pose.to_hand(from_m), to_local_m = pose.to_hand(to_m);
    double factor = 1.0;
    for (int n = 0; n < view_.per_length; ++n) factor *= pose.scale;
    const Extent quiet_local{quiet.min * factor, quiet.max * factor};
    Stretch piece = timed_ ? timed_->stretch_at(from_local_m, to_local_m, begin, quiet_local, at)
                           : view_.field->stretch(from_local_m, to_local_m, begin, quiet_local);
    bool finite = true;
    for (int i = 0; i <= piece.degree; ++i) {
      piece.control[i] /= factor;
      finite = finite && std::isfinite(piece.control[i]);
    }
    return finite ? piece : Stretch{.end = piece.end};
  }

  Carried carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept override {
    const Similarity before = pose_at(view_.track, from), after = pose_at(view_.track, to);
    if (jumps_between(from, to)) return {world_m, false};
    if (before == after && !timed_) return {world_m};
    const Vec3 local_m = before.to_hand(world_m);
    const Carried inner = timed_ ? timed_->carried(local_m, from, to) : Carried{local_m};
    if (before == after && inner.position_m == local_m) return {world_m, inner.known};
    const Vec3 carried_m = after.to_world(inner.position_m);
    return is_finite(carried_m) ? Carried{carried_m, inner.known} : Carried{world_m, false};
  }

  std::vector<Extent> extents() const override {
    std::vector<Extent> ranges = view_.field->extents();
    if (ranges.size() == 3) {
      double squared = 0.0;
      for (const Extent& e : ranges) squared += std::max(e.min * e.min, e.max * e.max);
      const double length = std::min(std::sqrt(squared), std::numeric_limits<double>::max());
      ranges.assign(3, {-length, length});
    }
    const double least = std::pow(least_scale_, -view_.per_length), most = std::pow(largest_scale_, -view_.per_length);
    for (Extent& e : ranges) {
      e = {std::min(e.min * least, e.min * most), std::max(e.max * least, e.max * most)};
    }
    return ranges;
  }

 private:
  double per_length(double value, const Similarity& pose) const noexcept {
    for (int n = 0; n < view_.per_length; ++n) value /= pose.scale;
    return value;
  }

  /// A loop whose end is not its beginning has a jump there.
  bool jumps_between(DataTime from, DataTime to) const noexcept {
    if (!from.loop || view_.track.size() < 2 || view_.track.front().pose == view_.track.back().pose) return false;
    const double length_s = view_.track.back().time_s;
    return std::floor(from.time_s / length_s) != std::floor(to.time_s / length_s);
  }

  /// Of the corners, at moments so close that the way between two of them is nearly straight; what it bends is added:
  /// a corner at distance r of the origin turned at ω and scaled at λ (per share of the way) has the
  /// acceleration r s (ω² + λ²), and its way bends by an eighth of that times the square of the share.
  void find_bounds() {
    constexpr int parts = 64;
    const Box box = view_.field->bounds_m();
    double reach_m = 0.0;
    bool any = false;
    const auto add = [&](const Similarity& pose, double bend_m) {
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 local{corner & 1 ? box.high_m.x : box.low_m.x, corner & 2 ? box.high_m.y : box.low_m.y,
                         corner & 4 ? box.high_m.z : box.low_m.z};
        reach_m = std::max(reach_m, norm(local));
        const Vec3 world = pose.to_world(local), bend{bend_m, bend_m, bend_m};
        const Vec3 low = world - bend, high = world + bend;
        if (!any) bounds_m_ = {low, high};
        any = true;
        bounds_m_.low_m = {std::min(bounds_m_.low_m.x, low.x), std::min(bounds_m_.low_m.y, low.y),
                           std::min(bounds_m_.low_m.z, low.z)};
        bounds_m_.high_m = {std::max(bounds_m_.high_m.x, high.x), std::max(bounds_m_.high_m.y, high.y),
                            std::max(bounds_m_.high_m.z, high.z)};
      }
    };
    for (const TimedPose& key : view_.track) add(key.pose, 0.0);
    for (std::size_t i = 1; i < view_.track.size(); ++i) {
      const TimedPose &a = view_.track[i - 1], &b = view_.track[i];
      const double angle = turn_between(a.pose.rotation, b.pose.rotation).angle;
      const double growth = std::log(b.pose.scale / a.pose.scale);
      if (angle == 0.0 && growth == 0.0) continue;
      const double bend_m =
          std::max(a.pose.scale, b.pose.scale) * reach_m * (angle * angle + growth * growth) / (8.0 * parts * parts);
      for (int part = 1; part < parts; ++part) {
        const double share = static_cast<double>(part) / parts;
        add(pose_at(view_.track, a.time_s + share * (b.time_s - a.time_s)), bend_m);
      }
    }
  }

  MovingView view_;
  const TimedField* timed_;
  Box bounds_m_;
  double least_scale_ = std::numeric_limits<double>::max();
  double largest_scale_ = 0.0;
};

}  // namespace

double DataTime::within(double cycle_s) const noexcept {
  if (!std::isfinite(time_s)) return 0.0;
  if (!loop) return std::clamp(time_s, 0.0, cycle_s);
  const double rest = std::fmod(time_s, cycle_s);
  return rest < 0.0 ? rest + cycle_s : rest;
}

ScalarSample TimedField::scalar_at(const Vec3&, DataTime) const noexcept { return {}; }
VectorSample TimedField::vector_at(const Vec3&, DataTime) const noexcept { return {}; }
Mat3 TimedField::hessian_at(const Vec3& world_m, DataTime at) const noexcept {
  return Moment(*this, at).hessian(world_m);  // Field's own, by differences
}

Stretch TimedField::stretch_at(const Vec3& from_m, const Vec3& to_m, double begin, const Extent& quiet,
                               DataTime at) const noexcept {
  return Moment(*this, at).stretch(from_m, to_m, begin, quiet);  // likewise
}

Carried TimedField::carried_with_level(const Vec3& world_m, DataTime from, DataTime to, double noise) const noexcept {
  if (from == to) return {world_m};
  const ScalarSample start = scalar_at(world_m, from);
  if (!start.inside) return {world_m};  // nothing is there that could have moved
  const Carried lost{world_m, false};
  constexpr int most_steps = 8;
  constexpr double on_level = 1e-9, near_level = 1e-3;  // of a spacing
  const double h = spacing_m();
  Vec3 at_m = world_m;
  for (int step = 0;; ++step) {
    const ScalarSample now = scalar_at(at_m, to);
    if (!now.inside) return lost;
    const double rest = start.value - now.value;
    if (rest == 0.0) return {at_m};
    const double steepness = norm(now.gradient);
    if (!(steepness > noise)) return lost;
    const double way_m = rest / steepness;
    if (std::abs(way_m) <= on_level * h) return {at_m};
    if (step == most_steps) return std::abs(way_m) <= near_level * h ? Carried{at_m} : lost;
    at_m += way_m * (now.gradient / steepness);
    if (!(distance(at_m, world_m) <= 0.5 * h)) return lost;
  }
}

const TimedField* timed(const Field& field) noexcept { return dynamic_cast<const TimedField*>(&field); }

FieldPtr frozen(FieldPtr field, DataTime at) {
  if (!field || !timed(*field)) return field;
  return std::make_shared<const Frozen>(std::move(field), at);
}

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
  return std::make_shared<const Series>(std::move(frames), period_s, between_frames);
}

const SeriesView* series_of(const Field& field) noexcept {
  const auto* series = dynamic_cast<const Series*>(&field);
  return series ? &series->view() : nullptr;
}

Similarity pose_at(const PoseTrack& track, DataTime at) noexcept {
  if (track.empty()) return {};
  if (track.size() == 1) return track.front().pose;
  const double t = at.within(track.back().time_s);
  const auto next = std::upper_bound(track.begin(), track.end(), t, [](double s, const TimedPose& p) { return s < p.time_s; });
  if (next == track.begin()) return track.front().pose;
  const TimedPose& a = *(next - 1);
  if (next == track.end() || a.time_s == t) return a.pose;
  const TimedPose& b = *next;
  const double u = (t - a.time_s) / (b.time_s - a.time_s);
  const auto between = [u](double from, double to) { return from + u * (to - from); };
  Similarity pose = a.pose;
  if (const Turn turn = turn_between(a.pose.rotation, b.pose.rotation); turn.angle > 0.0) {
    pose.rotation = rotation_about(turn.axis, u * turn.angle) * a.pose.rotation;
  }
  if (b.pose.scale != a.pose.scale) pose.scale = a.pose.scale * std::pow(b.pose.scale / a.pose.scale, u);
  pose.translation_m = {between(a.pose.translation_m.x, b.pose.translation_m.x),
                        between(a.pose.translation_m.y, b.pose.translation_m.y),
                        between(a.pose.translation_m.z, b.pose.translation_m.z)};
  return pose;
}

const char* problem_with(const PoseTrack& track) noexcept {
  if (track.empty()) return "there are no poses; give at least one";
  if (track.front().time_s != 0.0) return "the first pose is not at 0 s; it must be";
  for (std::size_t i = 0; i < track.size(); ++i) {
    if (!is_usable(track[i].pose)) {
      return "a pose is no rotation, move and scale; it must be finite, of positive scale and no mirror";
    }
    if (i == 0) continue;
    if (!(track[i].time_s > track[i - 1].time_s) || !std::isfinite(track[i].time_s)) {
      return "the times of the poses do not rise; sort them, and give each moment once";
    }
    if (turn_between(track[i - 1].pose.rotation, track[i].pose.rotation).angle > half_turn * 179.0 / 180.0) {
      return "a turn of half a circle from one pose to the next goes either way round; give a pose in between";
    }
  }
  return nullptr;
}

FieldPtr moving(FieldPtr field, PoseTrack track, int per_length) {
  if (!field) throw std::invalid_argument("there is no field to move");
  if (const char* problem = problem_with(track)) throw std::invalid_argument(problem);
  if (track.size() == 1 && !timed(*field)) return posed(std::move(field), track.front().pose);
  return std::make_shared<const Moving>(std::move(field), std::move(track), per_length);
}

Volume moving(const Volume& volume, const PoseTrack& track) {
  Volume moved = volume;
  for (VolumeField& f : moved.fields) f.field = moving(std::move(f.field), track);
  return moved;
}

const MovingView* moving_of(const Field& field) noexcept {
  const auto* moved = dynamic_cast<const Moving*>(&field);
  return moved ? &moved->view() : nullptr;
}

FieldPtr sampled(const FieldPtr& field, int longest, int frames, BetweenFrames between_frames) {
  constexpr int most_frames = 1000;
  const TimedField* source = field ? timed(*field) : nullptr;
  if (!source) throw std::invalid_argument("the field does not change with time, so it has no frames to sample");
  if (frames < 1 || frames > most_frames) {
    throw std::invalid_argument("a time series cannot have " + std::to_string(frames) + " frames; 1 to 1000 it can");
  }
  const double period_s = source->cycle_s() / frames;
  std::vector<FieldPtr> grids;
  for (int i = 0; i < frames; ++i) grids.push_back(sampled(*frozen(field, i * period_s), longest));
  return time_series(std::move(grids), period_s, between_frames);
}

Volume sampled(const Volume& volume, int longest, int frames, BetweenFrames between_frames) {
  Volume grids = volume;
  grids.format = "grid";
  for (VolumeField& f : grids.fields) f.field = sampled(f.field, longest, frames, between_frames);
  return grids;
}

}  // namespace palpa
