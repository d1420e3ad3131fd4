#include "palpa/field/field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "palpa/field/timed_field.h"

namespace palpa {
namespace {

/// Sampled at pose⁻¹(x); what comes back is turned and scaled. Every scale is a plain factor or
/// quotient, so that a power of two changes no bit of a mantissa.
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

  Stretch stretch(const Vec3& from_m, const Vec3& to_m, double begin, const Extent& quiet) const noexcept override {
    return view_.field->stretch(view_.pose.to_hand(from_m), view_.pose.to_hand(to_m), begin, quiet);
  }

  Certificate certificate(const Vec3& world_m) const noexcept override {
    const double shift_m =
        16.0 * std::numeric_limits<double>::epsilon() * (norm(world_m) + norm(view_.pose.translation_m)) / view_.pose.scale;
    return view_.field->certificate(view_.pose.to_hand(world_m)).scaled(view_.pose.scale, shift_m);
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

  std::vector<Extent> extents() const override {
    const std::vector<Extent> still = view_.field->extents();
    if (still.size() != 3) return still;
    std::vector<Extent> turned(3);
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

}  // namespace

Certificate Certificate::scaled(double scale, double shift_m) const noexcept {
  const Certificate seen{((1.0 - 1e-12) * radius_m - 2.0 * shift_m) * scale, slope_per_m / scale,
                         rounding + 2.0 * slope_per_m * shift_m};
  const bool usable = seen.radius_m > 0.0 && std::isfinite(seen.radius_m + seen.slope_per_m + seen.rounding);
  return usable ? seen : Certificate{};
}

ScalarSample Field::scalar(const Vec3&) const noexcept { return {}; }
VectorSample Field::vector(const Vec3&) const noexcept { return {}; }

Mat3 Field::hessian(const Vec3& world_m) const noexcept {
  const ScalarSample here = scalar(world_m);
  if (!here.inside) return {};
  const double step_m = 0.25 * spacing_m();
  const Vec3 steps[3] = {{step_m, 0, 0}, {0, step_m, 0}, {0, 0, step_m}};
  Mat3 h;
  for (int a = 0; a < 3; ++a) {
    const ScalarSample ahead = scalar(world_m + steps[a]), behind = scalar(world_m - steps[a]);
    const int sides = int(ahead.inside) + int(behind.inside);  // at a face there is only one
    if (sides == 0) continue;
    h.row[a] = ((ahead.inside ? ahead : here).gradient - (behind.inside ? behind : here).gradient) / (sides * step_m);
  }
  const Mat3 symmetric =
      0.5 * Mat3{{h.row[0] + transposed(h).row[0], h.row[1] + transposed(h).row[1], h.row[2] + transposed(h).row[2]}};
  return is_finite(symmetric) ? symmetric : Mat3{};
}

Stretch Field::stretch(const Vec3& from_m, const Vec3& to_m, double begin, const Extent&) const noexcept {
  const Vec3 way_m = to_m - from_m;
  const double length_m = norm(way_m);
  Stretch piece;
  if (!is_finite(from_m) || !std::isfinite(length_m) || !(begin >= 0.0 && begin < 1.0)) return piece;
  const Box box = bounds_m();
  const double from[3] = {from_m.x, from_m.y, from_m.z}, way[3] = {way_m.x, way_m.y, way_m.z};
  const double low[3] = {box.low_m.x, box.low_m.y, box.low_m.z}, high[3] = {box.high_m.x, box.high_m.y, box.high_m.z};
  double enters = 0.0, leaves = 1.0;
  for (int a = 0; a < 3; ++a) {
    if (way[a] == 0.0) {
      if (from[a] < low[a] || from[a] > high[a]) return piece;
      continue;
    }
    const double one = (low[a] - from[a]) / way[a], other = (high[a] - from[a]) / way[a];
    enters = std::max(enters, std::min(one, other));
    leaves = std::min(leaves, std::max(one, other));
  }
  if (enters > leaves || (begin >= leaves && leaves < 1.0)) return piece;
  if (begin < enters) {
    piece.end = enters;
    return piece;
  }

  const auto place = [&](double s) { return s < 1.0 ? from_m + s * way_m : to_m; };
  if (components() != 1) {
    piece.end = leaves;
    piece.inside = vector(place(0.5 * (begin + leaves))).inside;
    return piece;
  }

  const double longest_m = 0.25 * spacing_m();
  const double whole = leaves - begin;
  const double share = length_m * whole > longest_m ? longest_m / length_m : whole;
  piece.end = share < whole ? std::max(begin + share, std::nextafter(begin, 1.0)) : leaves;
  const auto at = [&](double s) { return scalar(place(s)); };
  const ScalarSample first = at(begin), last = at(piece.end);
  const double step = piece.end - begin;
  if (first.inside && last.inside) {
    piece.inside = true;
    piece.degree = 3;
    piece.control[0] = first.value;
    piece.control[1] = first.value + step / 3.0 * dot(first.gradient, way_m);
    piece.control[2] = last.value - step / 3.0 * dot(last.gradient, way_m);
    piece.control[3] = last.value;
  } else {
    // An end on a face, by rounding, or next to a hole in the data: the tangent at the middle.
    const ScalarSample middle = at(begin + 0.5 * step);
    piece.inside = middle.inside;
    piece.degree = 1;
    const double half = 0.5 * step * dot(middle.gradient, way_m);
    piece.control[0] = middle.value - half;
    piece.control[1] = middle.value + half;
  }
  for (const double c : piece.control) {
    if (!std::isfinite(c)) piece.inside = false;
  }
  if (!piece.inside) piece = {.end = piece.end};
  return piece;
}

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

Volume posed(const Volume& volume, const Similarity& pose) {
  Volume moved = volume;
  for (VolumeField& f : moved.fields) f.field = posed(std::move(f.field), pose);
  return moved;
}

}  // namespace palpa
