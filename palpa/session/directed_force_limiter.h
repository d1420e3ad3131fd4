// Limit on the change of directed forces along the proxy's path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "palpa/solver/state_arena.h"
#include "palpa/solver/tool_law.h"

namespace palpa {

/// A directed force d moves the proxy by d/k, where it is sampled again: with |∂d/∂x| ≥ k the proxy of a still hand would
/// oscillate for ever. So along the proxy's path all directed forces together change by at most k/2 per metre, for any modes
/// and data; then every jump is followed by a jump of at most 7/8 its length, trial points included, and a still hand comes to
/// rest. Keeps the forces in a StateArena; one thread.
class DirectedForceLimiter {
 public:
  /// \param capacity  [1] of directed forces
  DirectedForceLimiter(StateArena& live, std::size_t capacity) : last_(live.add<Last>()), forces_(live.add<Force>(capacity)) {}
  void clear() noexcept;
  /// Limits the directed forces of the set, sampled at `at` [m], against those stored last; `moved_n` [N] of change are due
  /// to moving data. Returns the mode whose force changed fastest if any was limited; else -1.
  std::int32_t hold_back(PrimitiveSet& set, const Pose& at, const ToolLaw& law, double stiffness_n_per_m,
                         double moved_n = 0.0) const noexcept;
  /// Stores the directed forces of the set, sampled at `at` [m].
  void keep(const PrimitiveSet& set, const Pose& at) noexcept;

 private:
  struct Force {
    PrimitiveId id;
    Vec3 force_n;
  };
  struct Last {
    Pose at;
    std::uint32_t size = 0;  // number of forces
    bool any = false;
  };
  std::span<const Force> held() const noexcept { return forces_.first(last_.size); }

  Last& last_;
  std::span<Force> forces_;
};

}  // namespace palpa
