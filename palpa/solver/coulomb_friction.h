// Friction lines with strength proportional to the force of their plane.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "palpa/solver/primitives.h"
#include "palpa/solver/state_arena.h"
#include "palpa/solver/tool_law.h"

namespace palpa {

/// Solves for the balance in which every Coulomb friction line has its coefficient times the force of its plane as strength: a
/// fixed point, found by a secant from its last solution in one or two balances. Not variational (docs/theory.md): makes at
/// most `max_passes`; forces and strengths show any remaining difference. Keeps the strengths in a StateArena; allocates at
/// construction only; one thread.
class CoulombFriction {
 public:
  /// \param capacity  [1] of lines
  CoulombFriction(StateArena& live, std::size_t capacity);
  void clear() noexcept { known_ = 0; }

  /// Balances the set about its start, to within exact_bound_m. If a plane shares its load with others, its force depends on
  /// the law's split; the facets of a corner count together.
  /// \param most_iterations  [1] of the law: no further correction after as many
  Balance solve(ToolLaw& law, PrimitiveSet& set, const Pose& probe, double stiffness_n_per_m, double time_step_s,
                int most_iterations = std::numeric_limits<int>::max()) noexcept;

 private:
  // [1] Corrections of the strengths. More: longer worst tick; fewer: friction is further from coefficient × force.
  static constexpr int max_passes = 4;
  struct Line {
    PrimitiveId id;
    std::size_t index = 0;    // in the set
    double strength_n = 0.0;  // in the last balance
    double slope = 0.0;       // change of `wanted_n` per change of `strength_n`
    double before_n = 0.0;    // strength in the balance before the last
    double wanted_n = 0.0;    // coefficient times its plane's force in that balance
  };
  bool correct(Line& line, double wanted_n, double held_n, double tolerance_n, bool first) const noexcept;

  std::size_t& known_;  // lines of the last balance
  std::span<Line> last_;
  std::vector<Line> lines_;
};

}  // namespace palpa
