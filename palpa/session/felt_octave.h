// Felt octave of volumes larger than memory.
#pragma once

#include <span>

#include "palpa/data/octaves.h"

namespace palpa {

/// Rule of the felt octave λ: one number a tick for all fields in octaves, from the windows in force and the motion of the
/// proxy alone. It becomes finer by one octave in 25 ms, coarser in 50 ms or as fast as a face of a window comes near, and at
/// once where a tick's way would leave the windows (`forced`). Trivially copyable. One thread.
class FeltOctave {
 public:
  double octave() const noexcept { return octave_; }                           ///< [1] λ
  bool is_forced() const noexcept { return forced_; }                          ///< the last tick had to raise it at once
  const Vec3& velocity_m_per_s() const noexcept { return velocity_m_per_s_; }  ///< [world] of the proxy, mean of 5 ms

  /// Forgets the motion; the next tick begins at the finest octave that it can have.
  void reset() noexcept { *this = {}; }
  /// \param feet_m       [m, world] of the proxy
  /// \param way_m        [m, world] longest way of a foot in the tick, as the probe has moved
  /// \param time_step_s  [s] since the last tick
  /// \param pose_time    at which the data are posed
  void advance(const Stock& stock, std::span<const Vec3> feet_m, double way_m, double time_step_s, DataTime pose_time) noexcept;

 private:
  double octave_ = 0.0;
  Vec3 last_m_;              // first foot in the last tick
  Vec3 velocity_m_per_s_{};  // of the proxy in the world
  bool started_ = false;
  bool forced_ = false;
};

}  // namespace palpa
