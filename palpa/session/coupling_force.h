// The coupling's pull on the hand, tick by tick: Eq. 1, less what waits, and its share of the energy.
#pragma once

#include "palpa/session/damper.h"
#include "palpa/session/lag_compensator.h"
#include "palpa/solver/coupling.h"

namespace palpa {

/// Where the walk of a tick has brought the proxy.
struct Walked {
  Vec3 from_m, proxy_m;  ///< [m] before and after it
  Vec3 followed_m;       ///< [m] the place on the probe's path that the proxy has followed it to
  Vec3 released_m;       ///< [m] the part of the proxy's motion that was a release
  bool waits = false;    ///< a part of the probe's path is still to be walked
};

/// The coupling's pull on the hand, and what its next tick depends on. Copied as bytes. Allocates nothing; one thread.
class CouplingForce {
 public:
  explicit CouplingForce(const Damper& damper = Damper{0.0}) noexcept : damper_(damper) {}

  /// The hand comes anew, at `probe_m` [m]: what the springs hold still is lost.
  void start(const Vec3& probe_m) noexcept;
  /// Nothing is held any more, as after a gap.
  void let_go() noexcept;
  /// What the springs held [J], which nobody gets.
  double lose_stored_j() noexcept;
  /// Goes on for `other`. \param damper   of the own coupling; \param keeps_it  the other's is the same, and so is the proxy
  void resume_in_changed_scene(const CouplingForce& other, const Damper& damper, bool keeps_it, const Vec3& proxy_m) noexcept;

  /// How far the hand has moved since the last tick [m].
  Vec3 step_m(const Vec3& probe_m) const noexcept { return probe_m - last_probe_m_; }
  /// Eq. 1 in one tick: the force on the hand, and the proxy's velocity less the probe's as the damper sees it.
  struct Answer {
    Vec3 force_n;
    Vec3 relative_m_per_s;
    bool has_just_faded = false;  ///< so long has something waited that nothing is felt any more
    double given_back_n = 0.0;    ///< of the force: what was withheld and has come back in this tick
  };
  /// \param time_step_s  [s] > 0
  Answer answer(const Walked& walked, const Vec3& probe_m, const CouplingOptions& coupling, double time_step_s) noexcept;
  /// Adds to a tick's energy, after `answer`, what the pull knows of it.
  void book(Energy& energy) noexcept;
  const Damper& damper() const noexcept { return damper_; }

 private:
  Damper damper_;
  LagCompensator slack_;
  Vec3 last_probe_m_;
  double waits_s_ = 0.0;                  // for how long something has waited
  Vec3 damper_force_n_;                   // held since the last tick
  double stored_j_ = 0.0;                 // in the spring and in elastic levels since then
  double lost_j_ = 0.0, damper_j_ = 0.0;  // of this tick
};

}  // namespace palpa
