// A field that changes with time, at one moment: a plain field, without allocation.
#pragma once

#include "palpa/data/timed_field.h"

namespace palpa {

/// Timed field at a moment, resolved once for many samples: a plain field, a blend of two, or a timed field and a moment; as it
/// is, or moved by a pose. Sampling is as for `Field`, to the bit that of the timed field at that moment.
///
/// Trivially copyable; refers to the field, which must outlive it. Any thread.
class FieldAtMoment {
 public:
  /// No data.
  FieldAtMoment() noexcept = default;
  /// A plain field. Positions of grids of equal geometry are looked up once for all of them (`Samples`).
  explicit FieldAtMoment(const Field& plain) noexcept : one_(&plain) {}
  /// (1 − share) · one + share · other of two plain fields, of values and derivatives; a place is inside if it is in both.
  /// \param share    [1] 0…1
  /// \param largest  magnitude of the fields' values, in their own unit
  FieldAtMoment(const Field& one, const Field& other, double share, double largest) noexcept
      : one_(&one), other_(&other), share_(share), largest_(largest) {}
  /// Any timed field, by its functions of the moment.
  FieldAtMoment(const TimedField& field, DataTime at) noexcept : one_(&field), is_timed_(true), at_(at) {}
  /// The blend of two timed fields at the moment.
  /// \param share    [1] 0…1
  /// \param largest  magnitude of the fields' values, in their own unit
  FieldAtMoment(const TimedField& one, const TimedField& other, double share, double largest, DataTime at) noexcept
      : one_(&one), other_(&other), share_(share), largest_(largest), is_timed_(true), at_(at) {}

  /// Moved by a pose, of a field that is not.
  /// \param spacing_scale  [1] of its sample spacing
  /// \param per_length     [1] its values are divided by this power of the scale
  FieldAtMoment moved(const Similarity& pose, double spacing_scale, int per_length) const noexcept;
  bool is_moved() const noexcept { return is_moved_; }
  /// The plain field that this is; nullptr for all others.
  const Field* plain() const noexcept { return is_moved_ || is_timed_ || other_ ? nullptr : one_; }

  ScalarSample scalar(const Vec3& world_m) const noexcept;
  VectorSample vector(const Vec3& world_m) const noexcept;
  Mat3 hessian(const Vec3& world_m) const noexcept;
  /// From the share `begin` [1] on.
  PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet) const noexcept;
  LipschitzBound lipschitz_bound(const Vec3& world_m) const noexcept;
  double depth_m(const Vec3& world_m) const noexcept;
  double local_spacing_m(const Vec3& world_m) const noexcept;
  int values_per_sample() const noexcept;

 private:
  // Without the pose, at a position below it.
  ScalarSample scalar_below(const Vec3& local_m) const noexcept;
  VectorSample vector_below(const Vec3& local_m) const noexcept;
  Mat3 hessian_below(const Vec3& local_m) const noexcept;
  PolynomialPiece piece_below(const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet) const noexcept;
  LipschitzBound bound_below(const Vec3& local_m) const noexcept;
  double depth_below(const Vec3& local_m) const noexcept;
  double spacing_below(const Vec3& local_m) const noexcept;
  double per_length(double value) const noexcept {
    for (int n = 0; n < per_length_; ++n) value /= pose_.scale;
    return value;
  }

  const Field* one_ = nullptr;
  const Field* other_ = nullptr;
  double share_ = 0.0;     // [1] of the other
  double largest_ = 0.0;   // of both
  bool is_timed_ = false;  // both are sampled at the moment
  DataTime at_;
  bool is_moved_ = false;
  int per_length_ = 0;
  double spacing_scale_ = 1.0;
  Similarity pose_;
};

/// Base of timed fields that `at_moment` defines.
class FieldOfMoments : public TimedField {
 public:
  FieldAtMoment at_moment(DataTime at) const noexcept override = 0;
  ScalarSample scalar_at(const Vec3& world_m, DataTime at) const noexcept final { return at_moment(at).scalar(world_m); }
  VectorSample vector_at(const Vec3& world_m, DataTime at) const noexcept final { return at_moment(at).vector(world_m); }
  Mat3 hessian_at(const Vec3& world_m, DataTime at) const noexcept final { return at_moment(at).hessian(world_m); }
  /// From the share `begin` [1] on.
  PolynomialPiece piece_along_at(const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet,
                                 DataTime at) const noexcept final {
    return at_moment(at).piece_along(from_m, to_m, begin, quiet);
  }
  LipschitzBound lipschitz_bound_at(const Vec3& world_m, DataTime at) const noexcept final {
    return at_moment(at).lipschitz_bound(world_m);
  }
  /// Depth [m].
  double depth_at(const Vec3& world_m, DataTime at) const noexcept final { return at_moment(at).depth_m(world_m); }
  /// Local spacing [m].
  double local_spacing_at(const Vec3& world_m, DataTime at) const noexcept final {
    return at_moment(at).local_spacing_m(world_m);
  }
};

}  // namespace palpa
