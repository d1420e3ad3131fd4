// What of the coupling's stretch does not pull, because it waits.
#pragma once

#include "palpa/solver/vec3.h"

namespace palpa {

/// What of the coupling's stretch does not pull. A tick does so much work and no more; where data take more, a part of the
/// probe's path waits, and the spring is longer by the way that waits than the data make it. That is no force of the data. So
/// while something waits, and until all of the stretch is felt again, the stretch that is felt is
///
///     s = the point nearest to s₀ − Δp on the straight way from 0 to a (proxy − followed),
///
/// s₀ the one felt before, Δp the hand's step, `followed` the place on the probe's path that the proxy has followed it to. With
/// the force of the data at that place, a [1] falls from 1 to 0 while tick after tick waits, for 50 ms: what waits fades.
///
/// In a tick that waits this is passive whatever the proxy does in the meantime: |s| ≤ |s₀ − Δp|, so
/// k s₀·Δp ≤ k/2 |s₀|² − k/2 |s|² + k/2 |Δp|². Where nothing waits, proxy − probe is the stretch that the data make, and its
/// force is due, whatever came before: s, what the hand's own motion leaves or makes of it, is then lengthened towards
/// proxy − probe in equal steps, so that all of it is felt 20 ms after the last tick that waited, or later where a step would
/// be longer than a caller allows. At once it would be a kick. What such a lengthening adds to k/2 |s|² the hand has not paid;
/// it is a part of the spring's energy k/2 |proxy − probe|², which the ledger has booked as brought in when it was withheld
/// (docs/theory.md, 7.6).
///
/// Allocates nothing; one thread.
class LagCompensator {
 public:
  /// The stretch that is felt in this tick [m].
  /// \param stretch_m      [m] proxy − probe
  /// \param to_followed_m  [m] proxy − followed
  /// \param waits_s        [s] for how long something has waited; 0: nothing does, and `to_followed_m` is `stretch_m`
  /// \param left_m         [m] s₀ − Δp
  Vec3 felt_m(const Vec3& stretch_m, const Vec3& to_followed_m, double waits_s, const Vec3& left_m) noexcept;
  /// Lengthens the stretch that is felt, after `felt_m`, in a tick in which nothing waits. Returns by how much [m].
  /// \param time_step_s  [s] > 0
  /// \param most_m       [m] >= 0: by no more than this
  Vec3 give_back_m(double time_step_s, double most_m) noexcept;
  /// The part of the last stretch that was not felt [m].
  const Vec3& unfelt_m() const noexcept { return unfelt_m_; }
  /// Whether there is one: while nothing waits and there is none, all of the stretch is felt, and nobody need ask.
  bool any() const noexcept { return unfelt_m_ != Vec3{}; }
  /// Whether all of the force has faded.
  static bool has_faded(double waits_s) noexcept { return waits_s >= fade_s; }
  /// The proxy is put on the probe.
  void reset() noexcept { *this = {}; }

 private:
  // [s] Waiting for longer: nothing is felt. Longer: forces of where the hand is no more; shorter: one busy tick is felt as a
  // tick.
  static constexpr double fade_s = 0.05;
  // [s] All is given back within this, the time of a fall where a level lets go. Longer: a wall is missing for longer; shorter:
  // it comes back abruptly.
  static constexpr double give_back_s = 0.02;
  Vec3 unfelt_m_;
  double left_s_ = 0.0;  // of the time in which what is not felt is given back
};

}  // namespace palpa
