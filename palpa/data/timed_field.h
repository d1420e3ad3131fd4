// Data that change with time: the contract of a field that takes the moment as an argument, series of frames, and poses, one
// that stays or one that changes.
#pragma once

#include <cstdint>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/solver/similarity.h"

namespace palpa {

/// A moment of the data. It also says what follows a field's last moment, so that one scene can play the same fields once or in
/// a loop, each field over its own length.
struct DataTime {
  double time_s = 0.0;  ///< [s] since the first frame or pose; any finite number
  bool loop = false;    ///< after its end a field begins again; else it stays at its first and last moment

  constexpr DataTime() noexcept = default;
  constexpr DataTime(double at_s, bool looped = false) noexcept : time_s(at_s), loop(looped) {}
  /// The moment within a cycle of this length [s], above 0: from 0 to its end; 0 for a moment that is not finite.
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
  /// As `Field::piece_along`, from the share `begin` [1] on, at one moment. A series of grids is exact as well.
  virtual PolynomialPiece piece_along_at(const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet,
                                         DataTime at) const noexcept;
  virtual double depth_at(const Vec3& world_m, DataTime at) const noexcept = 0;  ///< [m]
  /// As `Field::local_spacing_m`, at one moment [m].
  virtual double local_spacing_at(const Vec3& world_m, DataTime at) const noexcept {
    return static_cast<void>(world_m), static_cast<void>(at), spacing_m();
  }

  /// Where the point of the data that is at a world position [m] at the moment `from` is at the moment `to`. A volume that
  /// moves carries its points exactly. Where only values change, a scalar field's point keeps its value and
  /// moves along the gradient: by −φ_t g/|g|² for a short time. `known` is false where this fails: the gradient is no more than
  /// noise, or the level has moved by more than half a spacing at once, or is gone. Points of a vector field whose values
  /// change stay where they are.
  virtual Carried carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept = 0;
  /// The position alone [m].
  Vec3 carried_m(const Vec3& world_m, DataTime from, DataTime to) const noexcept {
    return carried(world_m, from, to).position_m;
  }

  /// The length of a loop [s], > 0. The loop of a series ends one period after its last frame.
  virtual double cycle_s() const noexcept = 0;
  /// The time [s] over which the field may change its course, > 0: from frame to frame, from pose to pose.
  virtual double time_spacing_s() const noexcept = 0;

  ScalarSample scalar(const Vec3& world_m) const noexcept final { return scalar_at(world_m, {}); }
  VectorSample vector(const Vec3& world_m) const noexcept final { return vector_at(world_m, {}); }
  Mat3 hessian(const Vec3& world_m) const noexcept final { return hessian_at(world_m, {}); }
  /// From the share `begin` [1] on.
  PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                              const ValueRange& quiet) const noexcept final {
    return piece_along_at(from_m, to_m, begin, quiet, {});
  }
  double depth_m(const Vec3& world_m) const noexcept final { return depth_at(world_m, {}); }
  double local_spacing_m(const Vec3& world_m) const noexcept final { return local_spacing_at(world_m, {}); }

 protected:
  /// `carried` of a scalar field whose values change: Newton's steps along the gradient at the later moment, back to the
  /// value of the earlier one; the first is −(φ_to − φ_from) g/|g|².
  /// \param noise  [unit/m] a gradient no longer than this says nothing
  Carried carried_with_level(const Vec3& world_m, DataTime from, DataTime to, double noise) const noexcept;
};

/// The field as a timed one; nullptr for a field that does not change with time.
const TimedField* timed(const Field& field) noexcept;
/// The field as it is at one moment; the field itself if it is not timed. Allocates.
FieldPtr frozen(FieldPtr field, DataTime at);

/// What a series is between two frames.
enum class BetweenFrames : std::uint8_t {
  linear,   ///< values and derivatives are blended; a level moves along if it shifts by less than the width of its edge
  nearest,  ///< the nearer frame: everything jumps half way between frames
};

/// Frames of one grid or box at equal distances in time: frame i at i · period. Looped, the last frame is followed by the
/// first, one period later, and blends into it; else there is nothing before the first and after the last.
///
/// A linear blend is one of values, gradients, Jacobians and Hessians, so each of them stays the exact derivative of the
/// value at every moment; at a frame it is that frame, to the bit. A place is inside where both frames are.
/// A frame must not be timed itself. Keeps the frames, and needs no memory beyond them.
///
/// \param frames    at least one; the same components, box and spacing
/// \param period_s  [s] from frame to frame, above 0 and finite
/// Reads 4096 places of the frames for the noise of their gradients. Throws std::invalid_argument, with a sentence.
FieldPtr time_series(std::vector<FieldPtr> frames, double period_s, BetweenFrames between_frames = BetweenFrames::linear);

/// Why a field cannot follow another one in a series, as the end of a sentence; nullptr if it can.
const char* problem_with_frame(const Field& first, const Field& frame) noexcept;

/// The frames behind a field made by `time_series`; nullptr for other fields.
struct SeriesView {
  std::vector<FieldPtr> frames;
  double period_s = 1.0;
  BetweenFrames between_frames = BetweenFrames::linear;
};
const SeriesView* series_of(const Field& field) noexcept;

/// The field moved by a pose: sampled at pose⁻¹(x), vectors and derivatives turned with it. Scalar values
/// do not change. A timed field stays timed. Allocates; throws std::invalid_argument on a pose that is not usable.
FieldPtr posed(FieldPtr field, const Similarity& pose);

/// The arguments from which `posed` made a field.
struct PosedView {
  FieldPtr field;
  Similarity pose;
};
/// nullptr for other fields.
const PosedView* posed_of(const Field& field) noexcept;

/// Where a volume is at some moment.
struct TimedPose {
  double time_s = 0.0;
  Similarity pose;
  friend bool operator==(const TimedPose&, const TimedPose&) = default;
};
/// Poses in the order of time.
using PoseTrack = std::vector<TimedPose>;

/// The pose at a moment: between two poses the translation and the logarithm of the scale are linear, and the rotation turns
/// at constant rate about one axis, the shorter way. So a volume moves steadily from pose to pose, and its velocity is always
/// finite. At a pose its velocity steps, and the force of a drag with it: more poses make these steps smaller. At a pose the
/// result is that pose, to the bit. A loop lasts as long as the track, which should end where it begins.
Similarity pose_at(const PoseTrack& track, DataTime at) noexcept;

/// What is wrong with the track, as a sentence without its dot; nullptr when it can be used: at least one pose, the first
/// at time 0, times rising, poses usable, turns of less than 179 degrees from one to the next.
/// \param wrong  becomes the number of the first pose that is wrong, where it is given and there is one
const char* problem_with(const PoseTrack& track, std::size_t* wrong = nullptr) noexcept;

/// A field that moves: at each moment `posed(field, pose_at(track, moment))`. The field itself may be timed. A vector's range
/// holds it in any turn.
/// \param per_length  [1] the values are divided by this power of the scale, as those of a derivative are
/// Throws std::invalid_argument, with a sentence, on a track that cannot be used.
FieldPtr moving(FieldPtr field, PoseTrack track, int per_length = 0);

/// The arguments from which `moving`, or `posed` of a timed field, made a field.
struct MovingView {
  FieldPtr field;
  PoseTrack track;
  int per_length = 0;  ///< [1]
};
/// nullptr for other fields.
const MovingView* moving_of(const Field& field) noexcept;

}  // namespace palpa
