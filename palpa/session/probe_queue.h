// FIFO of probe poses not yet processed.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "palpa/solver/primitives.h"
#include "palpa/solver/tool.h"

namespace palpa {

/// Straight piece of the probe's path.
struct ProbeSegment {
  Pose from;
  Pose to;
  double time_s = 0.0;
  bool fresh = true;  ///< false: the probe stays at `to`, and the rest of a move towards it continues

  /// Its first `share` [1].
  ProbeSegment first(double share, const Tool& tool) const noexcept {
    return {from, tool.moved(from, share * tool.motion(from, to)), share * time_s, fresh};
  }
};

/// Path of the probe from the processed pose to the current pose. Fixed memory; one thread.
class ProbeQueue {
 public:
  /// Starts the path at a pose [m].
  void start(const Pose& probe) noexcept;
  bool empty() const noexcept { return size_ == 0; }
  /// Appends a pose [m] of the probe of `tool`, reached in `time_s` [s]. An excursion at more than `fastest_m_per_s` both ways
  /// is no hand's: its unprocessed corners are dropped. So is a path of more than 64 corners: replaces its last corner. Returns
  /// the way from the previous pose [m] (Tool::way_m).
  double push(const Pose& probe, double time_s, const Tool& tool) noexcept;
  /// Rest of the path to the next corner.
  ProbeSegment front() const noexcept { return {walked_, corners_[0].pose, corners_[0].time_s}; }
  /// Removes a processed segment of the path of `tool` from the front.
  void pop(const ProbeSegment& walked, const Tool& tool) noexcept {
    walked_ = walked.to;
    corners_[0].time_s = std::max(corners_[0].time_s - walked.time_s, shortest_time_s);  // rounding may leave none
    if (!tool.are_one(walked.to, corners_[0].pose)) return;
    std::copy(corners_.begin() + 1, corners_.begin() + static_cast<std::ptrdiff_t>(size_), corners_.begin());
    --size_;
  }
  /// Pose that was pushed last [m].
  const Pose& last() const noexcept { return before(size_); }
  /// Pose up to which the probe's path is processed [m].
  const Pose& processed_up_to() const noexcept { return walked_; }
  /// Duration from the end of the next segment to the current pose [s].
  double time_behind_s(const ProbeSegment& next) const noexcept;

 private:
  // [m/s] Less: fast strokes are cut short while they wait; more: a bad sample takes the force away for longer.
  static constexpr double fastest_m_per_s = 10.0;
  struct Corner {
    Pose pose;
    double time_s = 0.0;  // from the previous corner, or from the processed pose
  };
  const Pose& before(std::size_t corner) const noexcept { return corner > 0 ? corners_[corner - 1].pose : walked_; }

  std::array<Corner, 64> corners_;
  std::size_t size_ = 0;
  Pose walked_;
};

}  // namespace palpa
