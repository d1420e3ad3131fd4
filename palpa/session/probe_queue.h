// What the probe has done and the proxy has not followed yet.
#pragma once

#include <array>
#include <cstddef>

#include "palpa/solver/vec3.h"

namespace palpa {

/// A straight piece of the probe's path.
struct ProbeSegment {
  Vec3 from_m;
  Vec3 to_m;
  double time_s = 0.0;
  bool fresh = true;  ///< false: the probe stays at `to_m`, and what is left of a move towards it goes on

  /// Its beginning: `share` [1] of it.
  ProbeSegment first(double share) const noexcept { return {from_m, from_m + share * (to_m - from_m), share * time_s, fresh}; }
};

/// The probe's path from where the proxy has followed it to where the probe is: what a tick cannot finish waits here. Fixed
/// memory; one thread.
class ProbeQueue {
 public:
  /// The path begins at a position [m].
  void start(const Vec3& probe_m) noexcept;
  bool empty() const noexcept { return size_ == 0; }
  /// The probe has got to a position [m], in `time_s` [s]. A path of more than 64 corners is no hand's: its last one is cut.
  /// Returns how far that is from where it was [m].
  double push(const Vec3& probe_m, double time_s) noexcept;
  /// What is left of the way to the next corner.
  ProbeSegment front() const noexcept { return {walked_m_, corners_[0].position_m, corners_[0].time_s}; }
  /// A segment that begins where the path was followed to has been walked.
  void pop(const ProbeSegment& walked) noexcept;
  /// How far the probe's path has been followed [m].
  const Vec3& processed_up_to_m() const noexcept { return walked_m_; }
  /// How long it takes from the end of a segment that comes next to where the probe is [s].
  double time_behind_s(const ProbeSegment& next) const noexcept;

 private:
  struct Corner {
    Vec3 position_m;
    double time_s = 0.0;  // from the corner before, or from where the path was followed to
  };
  std::array<Corner, 64> corners_;
  std::size_t size_ = 0;
  Vec3 walked_m_;
};

}  // namespace palpa
