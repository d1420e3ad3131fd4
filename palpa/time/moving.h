// Fields under a pose: one that stays, or one that changes with time.
#pragma once

#include <vector>

#include "palpa/core/similarity.h"
#include "palpa/time/timed_field.h"

namespace palpa {

/// The field moved by a pose: sampled at pose⁻¹(x), vectors and derivatives turned with it. Values
/// stay what they are. A timed field stays timed. Throws std::invalid_argument on a pose that is not usable.
FieldPtr posed(FieldPtr field, const Similarity& pose);

/// What `posed` made a field of.
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
/// at constant rate about one axis, the shorter way. So a volume moves steadily from pose to pose, no faster than the poses
/// say, and its velocity is finite always; it steps at a pose, and the force of a drag with it: more poses make that smaller.
/// At a pose it is that pose, to the bit. A loop lasts as long as the track; it should end where it begins.
Similarity pose_at(const PoseTrack& track, DataTime at) noexcept;

/// What is wrong with the track, as a sentence without its dot; nullptr when it can be used: at least one pose, the first
/// at time 0, times rising, poses usable, turns of less than 179 degrees from one to the next.
const char* problem_with(const PoseTrack& track) noexcept;

/// A field that moves: at each moment `posed(field, pose_at(track, moment))`. The field itself may be timed. A vector's range
/// holds it in any turn.
/// \param per_length  [1] the values are divided by this power of the scale, as those of a derivative are
/// Throws std::invalid_argument, with a sentence, on a track that cannot be used.
FieldPtr moving(FieldPtr field, PoseTrack track, int per_length = 0);

/// What `moving`, or `posed` for a timed field, made a field of; nullptr for other fields.
struct MovingView {
  FieldPtr field;
  PoseTrack track;
  int per_length = 0;  ///< [1]
};
const MovingView* moving_of(const Field& field) noexcept;

}  // namespace palpa
