// Coupling force on the hand (Eq. 1), less the extension due to unprocessed probe motion.
#pragma once

#include "palpa/session/lag_compensator.h"
#include "palpa/solver/coupling.h"
#include "palpa/solver/damper.h"
#include "palpa/solver/tool.h"

namespace palpa {

struct Walk;

/// Spring and damper between proxy and probe, with their state. Trivially copyable. Allocates nothing; one thread.
class CouplingForce {
 public:
  explicit CouplingForce(const Damper& damper = Damper{0.0}) noexcept : damper_(damper) {}

  /// Restarts with proxy and probe at `probe` [m].
  void start(const Pose& probe) noexcept;
  /// Clears all forces, as after a gap.
  void reset() noexcept;
  /// Copies the state of `other`.
  /// \param damper    of this coupling
  /// \param keeps_it  the other's damper is equal, and so is the proxy
  /// \param extension_m  [m] from probe to proxy now
  void resume_in_changed_scene(const CouplingForce& other, const Damper& damper, bool keeps_it,
                               const Motion& extension_m) noexcept;

  /// Result of one tick.
  struct Update {
    Vec3 force_n;                 ///< [N] on the hand (Eq. 1), before any limit
    Vec3 torque_nm;               ///< [N·m] likewise, of a tool, about the device's point
    Motion probe_step_m;          ///< [m] since the last tick
    Vec3 relative_m_per_s;        ///< [m/s] v_proxy − v_probe as estimated
    double damper_j = 0.0;        ///< [J] work of all but the spring over `probe_step_m`, by the force held since the last tick
    double given_back_n = 0.0;    ///< [N] part of the force that was withheld in incomplete ticks and returned in this one
    bool has_just_faded = false;  ///< incomplete for so long that the force is zero from now on
  };
  /// \param time_step_s  [s] > 0
  Update update(const Walk& walk, const Pose& probe, const CouplingOptions& coupling, const Tool& tool,
                double time_step_s) noexcept;
  const Pose& last_probe() const noexcept { return last_probe_; }
  const Damper& damper() const noexcept { return damper_; }

 private:
  Damper damper_;
  LagCompensator lag_;
  Pose last_probe_;
  double lag_s_ = 0.0;  // duration of incomplete ticks
  // Held since the last tick:
  Vec3 damper_force_n_;
  Vec3 damper_torque_nm_;
};

}  // namespace palpa
