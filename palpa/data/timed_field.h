// Data that change with time: fields with the moment as an argument, series of frames, constant and changing poses.
#pragma once

#include <cstdint>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/solver/similarity.h"

namespace palpa {

class Stock;

/// Moment of the data, with the continuation after a field's last moment: a scene can play its fields once or in a loop, each
/// over its own length.
struct DataTime {
  double time_s = 0.0;  ///< [s] since the first frame or pose; any finite number
  bool loop = false;    ///< a field repeats after its end; else it stays at its first and last moment
  /// Of volumes larger than memory (octaves.h), the felt octave λ [1], 0 the finest, and the session's windows, which outlive
  /// the moment.
  double octave = 0.0;
  const Stock* stock = nullptr;

  constexpr DataTime() noexcept = default;
  constexpr DataTime(double at_s, bool looped = false) noexcept : time_s(at_s), loop(looped) {}
  /// Moment within a cycle of this length [s], above 0: from 0 to its end; 0 for a non-finite moment.
  double within(double cycle_s) const noexcept;
  friend bool operator==(const DataTime&, const DataTime&) = default;
};

/// New position of a point of the data.
struct Carried {
  Vec3 position_m;    ///< [m]
  bool known = true;  ///< false: undetermined by the data; the position is the old one
};

class FieldAtMoment;

/// Field that changes with time. Immutable like every field: a moment is an argument. As a plain field it is that of its first
/// moment; its box, range and spacing hold for all moments.
///
/// Sampling is as for `Field`: finite for any position and moment (a non-finite one is the first), never allocates or throws.
/// Fields derived from it, posed or sampled are timed as well.
class TimedField : public Field {
 public:
  virtual ScalarSample scalar_at(const Vec3& world_m, DataTime at) const noexcept;
  virtual VectorSample vector_at(const Vec3& world_m, DataTime at) const noexcept;
  virtual Mat3 hessian_at(const Vec3& world_m, DataTime at) const noexcept;  ///< by differences, like `Field::hessian`
  /// `Field::piece_along` from the share `begin` [1] on, at a moment. Exact for a series of grids, too.
  virtual PolynomialPiece piece_along_at(const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet,
                                         DataTime at) const noexcept;
  /// `Field::lipschitz_bound` at a moment; for that moment alone. Default: none.
  virtual LipschitzBound lipschitz_bound_at(const Vec3& world_m, DataTime at) const noexcept {
    return static_cast<void>(world_m), static_cast<void>(at), LipschitzBound{};
  }
  virtual double depth_at(const Vec3& world_m, DataTime at) const noexcept = 0;  ///< [m]
  /// `Field::local_spacing_m` at a moment [m].
  virtual double local_spacing_at(const Vec3& world_m, DataTime at) const noexcept {
    return static_cast<void>(world_m), static_cast<void>(at), spacing_m();
  }

  /// `Field::values_per_sample` at a moment.
  virtual int values_per_sample_at(DataTime at) const noexcept { return static_cast<void>(at), values_per_sample(); }
  /// This field at a moment, for many samples there: equal to the bit, and cheaper (field_at_moment.h).
  virtual FieldAtMoment at_moment(DataTime at) const noexcept;

  /// Position at the moment `to` of the data point at a world position [m] at the moment `from`. Exact for a volume that moves.
  /// If only values change, a scalar field's point keeps its value and moves along the gradient: by −φ_t g/|g|² for a short
  /// time. `known` is false on failure: the gradient is within noise, or the level has moved by more than half a spacing at
  /// once, or vanished. Points of a vector field with changing values do not move.
  virtual Carried carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept = 0;
  /// Position alone [m].
  Vec3 carried_m(const Vec3& world_m, DataTime from, DataTime to) const noexcept {
    return carried(world_m, from, to).position_m;
  }

  /// Length of a loop [s], > 0. The loop of a series ends one period after its last frame.
  virtual double cycle_s() const noexcept = 0;
  /// Time scale [s] of the field, > 0: from frame to frame, from pose to pose.
  virtual double time_spacing_s() const noexcept = 0;

  ScalarSample scalar(const Vec3& world_m) const noexcept final { return scalar_at(world_m, {}); }
  VectorSample vector(const Vec3& world_m) const noexcept final { return vector_at(world_m, {}); }
  Mat3 hessian(const Vec3& world_m) const noexcept final { return hessian_at(world_m, {}); }
  /// From the share `begin` [1] on.
  PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                              const ValueRange& quiet) const noexcept final {
    return piece_along_at(from_m, to_m, begin, quiet, {});
  }
  LipschitzBound lipschitz_bound(const Vec3& world_m) const noexcept final { return lipschitz_bound_at(world_m, {}); }
  double depth_m(const Vec3& world_m) const noexcept final { return depth_at(world_m, {}); }
  double local_spacing_m(const Vec3& world_m) const noexcept final { return local_spacing_at(world_m, {}); }

 protected:
  /// `carried` of a scalar field whose values change: Newton's method along the gradient at the later moment, to the value of
  /// the earlier one; the first step is −(φ_to − φ_from) g/|g|².
  /// \param noise  [unit/m] shorter gradients are ignored
  Carried carried_with_level(const Vec3& world_m, DataTime from, DataTime to, double noise) const noexcept;
};

/// The field as a timed one; nullptr if it does not change with time.
const TimedField* timed(const Field& field) noexcept;
/// The field at a moment; the field itself if not timed. Allocates.
FieldPtr frozen(FieldPtr field, DataTime at);

/// Interpolation of a series between two frames.
enum class BetweenFrames : std::uint8_t {
  linear,   ///< values and derivatives are blended; a level moves if it shifts by less than the width of its edge
  nearest,  ///< the nearer frame: jumps half way between frames
};

/// Frames of one grid or box at equal distances in time: frame i at i · period. Looped, the last frame blends into the first,
/// one period later; else the first and last frame extend in time.
///
/// A linear blend is one of values, gradients, Jacobians and Hessians, so each stays the exact derivative of the value at every
/// moment; at a frame it equals that frame, to the bit. A place is inside if it is in both frames. A frame must not be timed
/// itself, unless all are octaves of one shape (octaves.h). Keeps the frames, without further memory.
///
/// \param frames    at least one; equal components, box and spacing
/// \param period_s  [s] from frame to frame, above 0 and finite
/// Reads 4096 places of the first frame for the noise of its gradients. Throws std::invalid_argument, with a sentence.
FieldPtr time_series(std::vector<FieldPtr> frames, double period_s, BetweenFrames between_frames = BetweenFrames::linear);

/// Reason why a field cannot follow another in a series, as the end of a sentence; nullptr if it can.
const char* problem_with_frame(const Field& first, const Field& frame) noexcept;

/// Frames behind a field made by `time_series`; nullptr for other fields.
struct SeriesView {
  std::vector<FieldPtr> frames;
  double period_s = 1.0;
  BetweenFrames between_frames = BetweenFrames::linear;
};
const SeriesView* series_of(const Field& field) noexcept;
/// Position [frames] of a moment, 0 the first frame, below the number of frames: 2.25 is a quarter of the way from frame 2 to
/// frame 3.
double frame_at(const SeriesView& series, DataTime at) noexcept;

/// Field moved by a pose: sampled at pose⁻¹(x), vectors and derivatives rotated with it. Scalar values do not change. A timed
/// field stays timed. Allocates; throws std::invalid_argument on an invalid pose.
FieldPtr posed(FieldPtr field, const Similarity& pose);

/// Arguments of `posed`.
struct PosedView {
  FieldPtr field;
  Similarity pose;
};
/// nullptr for other fields.
const PosedView* posed_of(const Field& field) noexcept;

/// Pose of a volume at a moment.
struct TimedPose {
  double time_s = 0.0;
  Similarity pose;
  friend bool operator==(const TimedPose&, const TimedPose&) = default;
};
/// Poses in the order of time.
using PoseTrack = std::vector<TimedPose>;

/// Pose at a moment: between two poses the translation and the logarithm of the scale are linear, and the rotation is at
/// constant rate about one axis, by the smaller angle. So the velocity of a volume is finite and steady between poses. At a
/// pose its velocity steps, and the force of a drag with it: more poses make these steps smaller. At a pose the result is that
/// pose, to the bit. A loop is as long as the track, which should end where it begins.
Similarity pose_at(const PoseTrack& track, DataTime at) noexcept;

/// Fault of the track, as a sentence without its dot; nullptr if valid: at least one pose, the first at time 0, times rising,
/// poses valid, rotations of less than 179 degrees from one to the next.
/// \param wrong  set to the number of the first faulty pose, if given
const char* problem_with(const PoseTrack& track, std::size_t* wrong = nullptr) noexcept;

/// Moving field: at each moment `posed(field, pose_at(track, moment))`. The field itself may be timed. A vector's range
/// contains it in any rotation.
/// \param per_length  [1] values are divided by this power of the scale, as for derivatives
/// Throws std::invalid_argument, with a sentence, on an invalid track.
FieldPtr moving(FieldPtr field, PoseTrack track, int per_length = 0);

/// Arguments of `moving`, or of `posed` of a timed field.
struct MovingView {
  FieldPtr field;
  PoseTrack track;
  int per_length = 0;  ///< [1]
};
/// nullptr for other fields.
const MovingView* moving_of(const Field& field) noexcept;

}  // namespace palpa
