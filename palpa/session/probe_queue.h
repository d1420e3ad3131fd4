// FIFO of probe positions not yet processed.
#pragma once

#include <array>
#include <cstddef>

#include "palpa/solver/vec3.h"

namespace palpa {

/// Straight piece of the probe's path.
struct ProbeSegment {
  Vec3 from_m;
  Vec3 to_m;
  double time_s = 0.0;
  bool fresh = true;  ///< false: the probe stays at `to_m`, and the rest of a move towards it continues

  /// Its first `share` [1].
  ProbeSegment first(double share) const noexcept { return {from_m, from_m + share * (to_m - from_m), share * time_s, fresh}; }
};

/// Path of the probe from the processed position to the current one. Fixed memory; one thread.
class ProbeQueue {
 public:
  /// Starts the path at a position [m].
  void start(const Vec3& probe_m) noexcept;
  bool empty() const noexcept { return size_ == 0; }
  /// Appends a position [m], reached in `time_s` [s]. An excursion at more than `fastest_m_per_s` both ways is no hand's: its
  /// unprocessed corners are dropped. So is a path of more than 64 corners: replaces its last corner. Returns the distance from
  /// the previous position [m].
  double push(const Vec3& probe_m, double time_s) noexcept;
  /// Rest of the path to the next corner.
  ProbeSegment front() const noexcept { return {walked_m_, corners_[0].position_m, corners_[0].time_s}; }
  /// Removes a processed segment from the front.
  void pop(const ProbeSegment& walked) noexcept;
  /// Position up to which the probe's path is processed [m].
  const Vec3& processed_up_to_m() const noexcept { return walked_m_; }
  /// Duration from the end of the next segment to the current position [s].
  double time_behind_s(const ProbeSegment& next) const noexcept;

 private:
  // [m/s] Less: fast strokes are cut short while they wait; more: a bad sample takes the force away for longer.
  static constexpr double fastest_m_per_s = 10.0;
  struct Corner {
    Vec3 position_m;
    double time_s = 0.0;  // from the previous corner, or from the processed position
  };
  const Vec3& before(std::size_t corner) const noexcept { return corner > 0 ? corners_[corner - 1].position_m : walked_m_; }

  std::array<Corner, 64> corners_;
  std::size_t size_ = 0;
  Vec3 walked_m_;
};

}  // namespace palpa
