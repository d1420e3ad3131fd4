// How much of a move towards a balance may be gone.
#pragma once

#include "palpa/tick/felt_modes.h"
#include "palpa/tick/joint_balance.h"

namespace palpa {

/// A move of the proxy towards the balance of a sub-step. Lives as long as what it refers to.
class MoveLimits {
 public:
  MoveLimits(const JointBalance& joint, FeltModes& modes, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
             const Balance& to) noexcept
      : joint_(joint), modes_(modes), start_m_(start_m), probe_m_(probe_m), stiffness_n_per_m_(stiffness_n_per_m), to_(to) {}

  /// The share [1] of the move, at most `share` [1], after which the spring has less energy than before, both ends put back on
  /// the levels that hold the proxy; 0 where no share has. In a crease of a surface each side's plane leads into the other
  /// side; a full move would swing from one to the other for ever, a descending one comes to rest at the bottom. Samples.
  double descending_share(double share) const noexcept;
  /// The share [1] of the way to `end_m` [m] after which the proxy would be inside of what holds it: another wall of the same
  /// level, or the other side of a corner. Levels that hold are on no list of crossings, so they are looked for here. Samples.
  double share_outside(const Vec3& end_m) const noexcept;

 private:
  Vec3 put_back(const Vec3& x_m) const noexcept;

  const JointBalance& joint_;
  FeltModes& modes_;
  const Vec3& start_m_;
  const Vec3& probe_m_;
  double stiffness_n_per_m_;
  const Balance& to_;
};

}  // namespace palpa
