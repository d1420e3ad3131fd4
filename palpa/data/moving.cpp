#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "palpa/data/field_at_moment.h"

namespace palpa {
namespace {

constexpr double half_turn = std::numbers::pi;  // [rad]

/// Samples at pose⁻¹(x), rotated and scaled. Every scale is a plain factor or quotient, so that a power of two changes no bit
/// of a mantissa.
class Posed final : public Field {
 public:
  Posed(FieldPtr field, const Similarity& pose) : view_{std::move(field), pose} {
    const Box box = view_.field->bounds_m();
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 local{corner & 1 ? box.high_m.x : box.low_m.x, corner & 2 ? box.high_m.y : box.low_m.y,
                       corner & 4 ? box.high_m.z : box.low_m.z};
      const Vec3 world = view_.pose.to_world(local);
      if (corner == 0) bounds_m_ = {world, world};
      bounds_m_.low_m = {std::min(bounds_m_.low_m.x, world.x), std::min(bounds_m_.low_m.y, world.y),
                         std::min(bounds_m_.low_m.z, world.z)};
      bounds_m_.high_m = {std::max(bounds_m_.high_m.x, world.x), std::max(bounds_m_.high_m.y, world.y),
                          std::max(bounds_m_.high_m.z, world.z)};
    }
  }

  const PosedView& view() const noexcept { return view_; }

  int components() const noexcept override { return view_.field->components(); }
  int values_per_sample() const noexcept override { return view_.field->values_per_sample(); }

  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    ScalarSample s = view_.field->scalar(view_.pose.to_hand(world_m));
    s.gradient = view_.pose.rotation * s.gradient / view_.pose.scale;
    return is_finite(s.gradient) ? s : ScalarSample{};
  }

  VectorSample vector(const Vec3& world_m) const noexcept override {
    VectorSample s = view_.field->vector(view_.pose.to_hand(world_m));
    s.value = view_.pose.rotation * s.value;
    s.jacobian = view_.pose.rotation * s.jacobian * transposed(view_.pose.rotation);
    for (Vec3& row : s.jacobian.row) row = row / view_.pose.scale;
    return is_finite(s.value) && is_finite(s.jacobian) ? s : VectorSample{};
  }

  Mat3 hessian(const Vec3& world_m) const noexcept override {
    Mat3 h = view_.pose.rotation * view_.field->hessian(view_.pose.to_hand(world_m)) * transposed(view_.pose.rotation);
    for (Vec3& row : h.row) row = row / view_.pose.scale / view_.pose.scale;
    return is_finite(h) ? h : Mat3{};
  }

  PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                              const ValueRange& quiet) const noexcept override {
    return view_.field->piece_along(view_.pose.to_hand(from_m), view_.pose.to_hand(to_m), begin, quiet);
  }

  LipschitzBound lipschitz_bound(const Vec3& world_m) const noexcept override {
    return view_.field->lipschitz_bound(view_.pose.to_hand(world_m)).posed(view_.pose, world_m);
  }

  double spacing_m() const noexcept override { return view_.pose.scale * view_.field->spacing_m(); }
  double local_spacing_m(const Vec3& world_m) const noexcept override {
    return view_.pose.scale * view_.field->local_spacing_m(view_.pose.to_hand(world_m));
  }
  Box bounds_m() const noexcept override { return bounds_m_; }
  double depth_m(const Vec3& world_m) const noexcept override {
    const double depth = view_.pose.scale * view_.field->depth_m(view_.pose.to_hand(world_m));
    return std::isfinite(depth) ? depth : 0.0;
  }

  std::vector<ValueRange> value_ranges() const override {
    const std::vector<ValueRange> still = view_.field->value_ranges();
    if (still.size() != 3) return still;
    std::vector<ValueRange> turned(3);
    for (int i = 0; i < 3; ++i) {
      const Vec3& row = view_.pose.rotation.row[i];
      const double weights[3] = {row.x, row.y, row.z};
      for (int j = 0; j < 3; ++j) {
        const auto [low, high] = std::minmax({weights[j] * still[j].min, weights[j] * still[j].max});
        turned[i].min += low;
        turned[i].max += high;
      }
    }
    return turned;
  }

 private:
  PosedView view_;
  Box bounds_m_;
};

/// Rotation about `axis`, a unit vector, by an angle [rad] (O. Rodrigues, 1840).
Mat3 rotation_by(const Vec3& axis, double angle) noexcept {
  const double c = std::cos(angle), s = std::sin(angle), v = 1.0 - c;
  return {{{c + v * axis.x * axis.x, v * axis.x * axis.y - s * axis.z, v * axis.x * axis.z + s * axis.y},
           {v * axis.y * axis.x + s * axis.z, c + v * axis.y * axis.y, v * axis.y * axis.z - s * axis.x},
           {v * axis.z * axis.x - s * axis.y, v * axis.z * axis.y + s * axis.x, c + v * axis.z * axis.z}}};
}

/// Rotation between two others: R₁ = turn · R₀, about an axis of the world.
struct Turn {
  Vec3 axis;           ///< unit, or zero without rotation
  double angle = 0.0;  ///< [rad] 0…π
};
Turn turn_between(const Mat3& from, const Mat3& to) noexcept {
  const Mat3 r = to * transposed(from);
  const Vec3 twice_sine{r.row[2].y - r.row[1].z, r.row[0].z - r.row[2].x, r.row[1].x - r.row[0].y};
  const double twice_cosine = r.row[0].x + r.row[1].y + r.row[2].z - 1.0;
  return {normalized(twice_sine), std::atan2(norm(twice_sine), twice_cosine)};
}

class Moving final : public FieldOfMoments {
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
  int values_per_sample() const noexcept override { return view_.field->values_per_sample(); }
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

  FieldAtMoment at_moment(DataTime at) const noexcept override {
    FieldAtMoment still = timed_ ? timed_->at_moment(at) : FieldAtMoment(*view_.field);
    if (still.is_moved()) still = {*timed_, at};  // of two poses the inner one is found at each sample
    return still.moved(pose_at(view_.track, at), least_scale_, view_.per_length);
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

  std::vector<ValueRange> value_ranges() const override {
    std::vector<ValueRange> ranges = view_.field->value_ranges();
    if (ranges.size() == 3) {
      double squared = 0.0;
      for (const ValueRange& e : ranges) squared += std::max(e.min * e.min, e.max * e.max);
      const double length = std::min(std::sqrt(squared), std::numeric_limits<double>::max());
      ranges.assign(3, {-length, length});
    }
    const double least = std::pow(least_scale_, -view_.per_length), most = std::pow(largest_scale_, -view_.per_length);
    for (ValueRange& e : ranges) {
      e = {std::min(e.min * least, e.min * most), std::max(e.max * least, e.max * most)};
    }
    return ranges;
  }

 private:
  /// A loop with different start and end has a jump there.
  bool jumps_between(DataTime from, DataTime to) const noexcept {
    if (!from.loop || view_.track.size() < 2 || view_.track.front().pose == view_.track.back().pose) return false;
    const double length_s = view_.track.back().time_s;
    return std::floor(from.time_s / length_s) != std::floor(to.time_s / length_s);
  }

  /// From the corners, at moments so close that the path between two of them is nearly straight, plus its deviation: a corner
  /// at distance r of the origin rotating at ω and scaling at λ (per share of the path) has the acceleration r s (ω² + λ²), so
  /// the deviation is an eighth of that times the square of the share.
  void find_bounds() {
    constexpr int parts = 64;  // [1] per piece of the track. More: slower; fewer: wider bounds, by the deviation
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

FieldPtr posed(FieldPtr field, const Similarity& pose) {
  if (!field) throw std::invalid_argument("there is no field to pose");
  if (!is_usable(pose)) {
    throw std::invalid_argument("the pose is no rotation, move and scale; it must be finite, of positive scale and no mirror");
  }
  if (pose == Similarity{}) return field;
  if (timed(*field)) return moving(std::move(field), {{0.0, pose}});
  return std::make_shared<const Posed>(std::move(field), pose);
}

const PosedView* posed_of(const Field& field) noexcept {
  const auto* moved = dynamic_cast<const Posed*>(&field);
  return moved ? &moved->view() : nullptr;
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
    pose.rotation = rotation_by(turn.axis, u * turn.angle) * a.pose.rotation;
  }
  if (b.pose.scale != a.pose.scale) pose.scale = a.pose.scale * std::pow(b.pose.scale / a.pose.scale, u);
  pose.translation_m = {between(a.pose.translation_m.x, b.pose.translation_m.x),
                        between(a.pose.translation_m.y, b.pose.translation_m.y),
                        between(a.pose.translation_m.z, b.pose.translation_m.z)};
  return pose;
}

const char* problem_with(const PoseTrack& track, std::size_t* wrong) noexcept {
  if (wrong) *wrong = 0;
  if (track.empty()) return "there are no poses; give at least one";
  if (track.front().time_s != 0.0) return "the first pose is not at 0 s; it must be";
  for (std::size_t i = 0; i < track.size(); ++i) {
    if (wrong) *wrong = i;
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

const MovingView* moving_of(const Field& field) noexcept {
  const auto* moved = dynamic_cast<const Moving*>(&field);
  return moved ? &moved->view() : nullptr;
}

}  // namespace palpa
