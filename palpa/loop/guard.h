// The guard: the last word on every force.
#pragma once

#include "palpa/core/vec3.h"
#include "palpa/trace/record.h"

namespace palpa {

/// Lets a force through, shortens it to a limit (keeping its direction), or, for anything that is not
/// finite, lets nothing through and reports a fault. Allocates nothing.
class Guard {
 public:
  /// \param max_force_n  [N] >= 0: the smaller of the scene's and the device's limit; a limit that is
  ///                     no such number lets nothing through
  explicit Guard(double max_force_n) noexcept : max_force_n_(max_force_n >= 0.0 ? max_force_n : 0.0) {}

  struct Passed {
    Vec3 command_n;  ///< never longer than the limit, rounding included
    GuardState state = GuardState::pass;
  };
  Passed pass(const Vec3& force_n) noexcept;

 private:
  double max_force_n_;
};

}  // namespace palpa
