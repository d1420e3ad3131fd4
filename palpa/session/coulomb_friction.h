// Friction as strong as the plane that it belongs to.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "palpa/mode/state_arena.h"
#include "palpa/solver/law.h"
#include "palpa/solver/primitives.h"

namespace palpa {

/// Finds the balance in which every line of Coulomb friction is as strong as its plane presses in it: a fixed point, looked
/// for by a secant from where it was last, which takes one or two balances. Not variational (docs/theory.md): at most
/// `max_passes` are made, and what is still missing then is the caller's to see, in forces and strengths. Keeps in a block
/// how strong they were; takes its memory at construction; one thread.
class CoulombFriction {
 public:
  /// \param capacity  [1] of lines
  CoulombFriction(StateArena& live, std::size_t capacity);
  void clear() noexcept { known_ = 0; }

  /// Balances the set about its start, its lines of friction as strong as their planes, to what shifts the proxy by less than
  /// counts as exact. Where a plane shares its load with others, its force is that of one split of several, the law's; the
  /// facets of a corner press together.
  /// \param most_iterations  [1] of the law: after as many no further correction is made
  Balance solve(Law& law, PrimitiveSet& set, const Vec3& probe_m, double stiffness_n_per_m, double time_step_s,
                int most_iterations = std::numeric_limits<int>::max()) noexcept;

 private:
  // [1] Corrections of the strengths. More: longer worst tick; fewer: friction is further from coefficient × force.
  static constexpr int max_passes = 4;
  struct Line {
    PrimitiveId id;
    std::size_t index = 0;    // in the set
    double strength_n = 0.0;  // in the last balance
    double slope = 0.0;       // by how much its plane's force changes what it should be
    double before_n = 0.0;    // its strength in the balance before the last
    double wanted_n = 0.0;    // the strength that its plane's force asked for in that balance
  };
  bool correct(Line& line, double wanted_n, double held_n, double tolerance_n, bool first) const noexcept;

  std::size_t& known_;  // of the last balance's lines
  std::span<Line> last_;
  std::vector<Line> lines_;
};

}  // namespace palpa
