// Data that change with time: a field that takes the moment as an argument.
#pragma once

#include "palpa/field/field.h"

namespace palpa {

/// A moment of the data. What lies beyond a field's last moment is decided here, so that one scene can
/// play the same fields once or in a loop, each field over its own length.
struct DataTime {
  double time_s = 0.0;  ///< [s] since the first frame or pose; any finite number
  bool loop = false;    ///< after its end a field begins again; else it stays at its first and last moment

  constexpr DataTime() noexcept = default;
  constexpr DataTime(double at_s, bool looped = false) noexcept : time_s(at_s), loop(looped) {}
  /// The moment as one between 0 and the end of a cycle of this length [s], above 0; the first for one that is not finite.
  double within(double cycle_s) const noexcept;
  friend bool operator==(const DataTime&, const DataTime&) = default;
};

/// Where a point of the data has gone.
struct Carried {
  Vec3 position_m;    ///< [m]
  bool known = true;  ///< false: the data say nothing about it, and the position is the old one
};

/// A field that changes with time. Immutable like every field: a moment is an argument. Asked as a plain
/// field it answers for its first moment, and its box, range and spacing hold for all moments.
///
/// Sampling is as for `Field`: finite for any position and moment (one that is not finite is the first),
/// never allocates or throws. Fields derived from it, posed or sampled are timed as well.
class TimedField : public Field {
 public:
  virtual ScalarSample scalar_at(const Vec3& world_m, DataTime at) const noexcept;
  virtual VectorSample vector_at(const Vec3& world_m, DataTime at) const noexcept;
  virtual Mat3 hessian_at(const Vec3& world_m, DataTime at) const noexcept;  ///< by differences, like `Field::hessian`
  /// As `Field::stretch`, from the share `begin` [1] on, at one moment: a series of grids is exact too.
  virtual Stretch stretch_at(const Vec3& from_m, const Vec3& to_m, double begin, const Extent& quiet,
                             DataTime at) const noexcept;
  virtual double depth_at(const Vec3& world_m, DataTime at) const noexcept = 0;  ///< [m]

  /// Where the data's point that is at a world position [m] at one moment is at another. A volume that
  /// moves carries its points exactly. Where only values change, a scalar field's point keeps its value and
  /// moves along the gradient: by −φ_t g/|g|² for a short time. `known` is false where that cannot be said:
  /// the gradient is no more than noise, or the level has moved by more than half a spacing at once, or is
  /// gone. The points of a vector field whose values change stay where they are.
  virtual Carried carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept = 0;
  /// The position alone [m].
  Vec3 carried_m(const Vec3& world_m, DataTime from, DataTime to) const noexcept {
    return carried(world_m, from, to).position_m;
  }

  /// The length of a loop [s], > 0: that of a series ends one period after its last frame.
  virtual double cycle_s() const noexcept = 0;
  /// The time [s] over which the field may change its course, > 0: from frame to frame, from pose to pose.
  virtual double time_spacing_s() const noexcept = 0;

  ScalarSample scalar(const Vec3& world_m) const noexcept final { return scalar_at(world_m, {}); }
  VectorSample vector(const Vec3& world_m) const noexcept final { return vector_at(world_m, {}); }
  Mat3 hessian(const Vec3& world_m) const noexcept final { return hessian_at(world_m, {}); }
  /// From the share `begin` [1] on.
  Stretch stretch(const Vec3& from_m, const Vec3& to_m, double begin, const Extent& quiet) const noexcept final {
    return stretch_at(from_m, to_m, begin, quiet, {});
  }
  double depth_m(const Vec3& world_m) const noexcept final { return depth_at(world_m, {}); }

 protected:
  /// `carried` of a scalar field whose values change: Newton's steps along the gradient at the later moment, back to the
  /// value of the earlier one; the first is −(φ_to − φ_from) g/|g|².
  /// \param noise  [unit/m] a gradient no longer than this says nothing
  Carried carried_with_level(const Vec3& world_m, DataTime from, DataTime to, double noise) const noexcept;
};

/// The field as a timed one; nullptr for a field that stays as it is.
const TimedField* timed(const Field& field) noexcept;
/// The field as it is at one moment; the field itself where it is not timed.
FieldPtr frozen(FieldPtr field, DataTime at);

}  // namespace palpa
