// Six scenes under a moving hand, as sequences of balance problems.
#pragma once

#include <vector>

#include "tests/solver/random_problems.h"

namespace palpa::bench {

/// One scene: 6000 ticks at 1 kHz, k = 800 N/m. Every tick places all primitives at the proxy (the exact balance of the tick
/// before), with slowly turning directions.
struct Scene {
  const char* name;
  bool one_mode;  ///< primitives of a single mode: point, line, or plane and line with one direction
  int primitives = 0;
  std::vector<test::Problem> ticks;
};

std::vector<Scene> scenes();

}  // namespace palpa::bench
