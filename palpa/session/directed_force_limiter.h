// Directed forces along the proxy's path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "palpa/mode/state_arena.h"
#include "palpa/solver/primitives.h"

namespace palpa {

/// A directed force d moves the proxy by d/k, where it is looked up again: with |∂d/∂x| ≥ k the proxy of a
/// still hand would jump to and fro for ever. So along the proxy's path all directed forces together change
/// by at most k/2 per metre, whatever modes and data say; then every jump is followed by one of at most 7/8 its
/// length, trial points included, and a still hand comes to rest. Keeps them in a block; one thread.
class DirectedForceLimiter {
 public:
  /// \param capacity  [1] of directed forces
  DirectedForceLimiter(StateArena& live, std::size_t capacity) : last_(live.add<Last>()), forces_(live.add<Force>(capacity)) {}
  void clear() noexcept;
  /// Limits the directed forces of the set, looked up at `at_m` [m], against those kept last; `moved_n` [N] of change are the
  /// data's own, which have moved since. Returns the mode whose force
  /// changed fastest if they had to be held back; -1 otherwise.
  std::int32_t hold_back(PrimitiveSet& set, const Vec3& at_m, double stiffness_n_per_m, double moved_n = 0.0) const noexcept;
  /// Keeps the directed forces of the set, looked up at `at_m` [m].
  void keep(const PrimitiveSet& set, const Vec3& at_m) noexcept;

 private:
  struct Force {
    PrimitiveId id;
    Vec3 force_n;
  };
  struct Last {
    Vec3 at_m;
    std::uint32_t size = 0;  // forces
    bool any = false;
  };
  std::span<const Force> held() const noexcept { return forces_.first(last_.size); }

  Last& last_;
  std::span<Force> forces_;
};

}  // namespace palpa
