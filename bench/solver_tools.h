// Balances of a tool's walks, and their times.
#pragma once

#include <string>
#include <vector>

#include "solver_clock.h"

namespace palpa::bench {

/// Balances of one walk, or of problems one by one.
struct ToolTimes {
  std::string name;
  int feet = 0;
  bool friction = false;
  double rows = 0.0;             ///< [1] primitives of a balance, mean
  std::vector<double> times_ns;  ///< by balance, the best of some repetitions
  double largest_bound_m = 0.0;
  int capped = 0;
};

/// Warm balances of a pad that walks over a plane and a sphere, and of a peg in a hole, for 1 to 256 feet, without and with
/// friction. A tick has up to four, each with primitives placed at the feet that are near the surface.
std::vector<ToolTimes> times_of_walks(const Clock& clock);

/// Cold balances of random feet jammed between opposed planes and lines (family `jammed` of the tests).
std::vector<ToolTimes> times_jammed(const Clock& clock, int problems);

}  // namespace palpa::bench
