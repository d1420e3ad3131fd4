#include "palpa/data/field_at_moment.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpa/data/blend.h"

namespace palpa {
namespace {

const TimedField& as_timed(const Field& field) noexcept { return static_cast<const TimedField&>(field); }

}  // namespace

FieldAtMoment FieldAtMoment::moved(const Similarity& pose, double spacing_scale, int per_length) const noexcept {
  FieldAtMoment there = *this;
  there.is_moved_ = true;
  there.pose_ = pose;
  there.spacing_scale_ = spacing_scale;
  there.per_length_ = per_length;
  return there;
}

ScalarSample FieldAtMoment::scalar_below(const Vec3& local_m) const noexcept {
  const auto sample = [&](const Field& field) {
    return is_timed_ ? as_timed(field).scalar_at(local_m, at_) : field.scalar(local_m);
  };
  if (!one_) return {};
  const ScalarSample a = sample(*one_);
  return other_ ? detail::blend(a, sample(*other_), share_) : a;
}

VectorSample FieldAtMoment::vector_below(const Vec3& local_m) const noexcept {
  const auto sample = [&](const Field& field) {
    return is_timed_ ? as_timed(field).vector_at(local_m, at_) : field.vector(local_m);
  };
  if (!one_) return {};
  const VectorSample a = sample(*one_);
  return other_ ? detail::blend(a, sample(*other_), share_) : a;
}

Mat3 FieldAtMoment::hessian_below(const Vec3& local_m) const noexcept {
  const auto sample = [&](const Field& field) {
    return is_timed_ ? as_timed(field).hessian_at(local_m, at_) : field.hessian(local_m);
  };
  if (!one_) return {};
  const Mat3 a = sample(*one_);
  if (!other_) return a;
  // A place in only one of the two is outside, without a derivative.
  return scalar_below(local_m).inside ? detail::blend(a, sample(*other_), share_) : Mat3{};
}

PolynomialPiece FieldAtMoment::piece_below(const Vec3& from_m, const Vec3& to_m, double begin,
                                           const ValueRange& quiet) const noexcept {
  const auto piece = [&](const Field& field, const ValueRange& within) {
    return is_timed_ ? as_timed(field).piece_along_at(from_m, to_m, begin, within, at_)
                     : field.piece_along(from_m, to_m, begin, within);
  };
  if (!one_) return {};
  if (!other_) return piece(*one_, quiet);
  return detail::blended_piece(begin, share_, quiet,
                               [&](bool second, const ValueRange& within) { return piece(second ? *other_ : *one_, within); });
}

LipschitzBound FieldAtMoment::bound_below(const Vec3& local_m) const noexcept {
  const auto bound = [&](const Field& field) {
    return is_timed_ ? as_timed(field).lipschitz_bound_at(local_m, at_) : field.lipschitz_bound(local_m);
  };
  if (!one_) return {};
  const LipschitzBound a = bound(*one_);
  return other_ && a.radius_m > 0.0 ? detail::blend(a, bound(*other_), share_, largest_) : a;
}

double FieldAtMoment::depth_below(const Vec3& local_m) const noexcept {
  const auto depth_m = [&](const Field& field) {
    return is_timed_ ? as_timed(field).depth_at(local_m, at_) : field.depth_m(local_m);
  };
  if (!one_) return 0.0;
  const double a = depth_m(*one_);
  return other_ ? std::min(a, depth_m(*other_)) : a;
}

double FieldAtMoment::spacing_below(const Vec3& local_m) const noexcept {
  if (!one_) return 1.0;
  return is_timed_ ? as_timed(*one_).local_spacing_at(local_m, at_) : one_->local_spacing_m(local_m);
}

ScalarSample FieldAtMoment::scalar(const Vec3& world_m) const noexcept {
  if (!is_moved_) return scalar_below(world_m);
  ScalarSample s = scalar_below(pose_.to_hand(world_m));
  s.value = per_length(s.value);
  s.gradient = pose_.rotation * s.gradient / pose_.scale;
  for (int n = 0; n < per_length_; ++n) s.gradient = s.gradient / pose_.scale;
  return std::isfinite(s.value) && is_finite(s.gradient) ? s : ScalarSample{};
}

VectorSample FieldAtMoment::vector(const Vec3& world_m) const noexcept {
  if (!is_moved_) return vector_below(world_m);
  VectorSample s = vector_below(pose_.to_hand(world_m));
  s.value = pose_.rotation * s.value;
  s.jacobian = pose_.rotation * s.jacobian * transposed(pose_.rotation);
  for (Vec3& row : s.jacobian.row) row = row / pose_.scale;
  for (int n = 0; n < per_length_; ++n) {
    s.value = s.value / pose_.scale;
    for (Vec3& row : s.jacobian.row) row = row / pose_.scale;
  }
  return is_finite(s.value) && is_finite(s.jacobian) ? s : VectorSample{};
}

Mat3 FieldAtMoment::hessian(const Vec3& world_m) const noexcept {
  if (!is_moved_) return hessian_below(world_m);
  Mat3 h = pose_.rotation * hessian_below(pose_.to_hand(world_m)) * transposed(pose_.rotation);
  for (Vec3& row : h.row) {
    row = row / pose_.scale / pose_.scale;
    for (int n = 0; n < per_length_; ++n) row = row / pose_.scale;
  }
  return is_finite(h) ? h : Mat3{};
}

PolynomialPiece FieldAtMoment::piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                                           const ValueRange& quiet) const noexcept {
  if (!is_moved_) return piece_below(from_m, to_m, begin, quiet);
  const Vec3 from_local_m = pose_.to_hand(from_m), to_local_m = pose_.to_hand(to_m);
  if (per_length_ == 0) return piece_below(from_local_m, to_local_m, begin, quiet);
  double factor = 1.0;
  for (int n = 0; n < per_length_; ++n) factor *= pose_.scale;
  PolynomialPiece piece = piece_below(from_local_m, to_local_m, begin, {quiet.min * factor, quiet.max * factor});
  bool finite = true;
  for (int i = 0; i <= piece.degree; ++i) {
    piece.control[i] /= factor;
    finite = finite && std::isfinite(piece.control[i]);
  }
  return finite ? piece : PolynomialPiece{.end = piece.end};
}

LipschitzBound FieldAtMoment::lipschitz_bound(const Vec3& world_m) const noexcept {
  if (!is_moved_) return bound_below(world_m);
  LipschitzBound bound = bound_below(pose_.to_hand(world_m)).posed(pose_, world_m);
  bound.slope_per_m = per_length(bound.slope_per_m);
  bound.rounding = per_length(bound.rounding);
  bound.bend_per_m2 = per_length(bound.bend_per_m2);
  bound.values = {per_length(bound.values.min), per_length(bound.values.max)};
  return std::isfinite(bound.slope_per_m + bound.rounding) ? bound : LipschitzBound{};
}

double FieldAtMoment::depth_m(const Vec3& world_m) const noexcept {
  if (!is_moved_) return depth_below(world_m);
  const double depth = pose_.scale * depth_below(pose_.to_hand(world_m));
  return std::isfinite(depth) ? depth : 0.0;
}

double FieldAtMoment::local_spacing_m(const Vec3& world_m) const noexcept {
  return is_moved_ ? spacing_scale_ * spacing_below(pose_.to_hand(world_m)) : spacing_below(world_m);
}

int FieldAtMoment::values_per_sample() const noexcept {
  const auto values = [&](const Field& field) {
    return is_timed_ ? as_timed(field).values_per_sample_at(at_) : field.values_per_sample();
  };
  if (!one_) return 1;
  return values(*one_) + (other_ ? values(*other_) : 0);
}

}  // namespace palpa
