// Six scenes under a moving hand, as the sequences of balance problems that they pose.
#pragma once

#include <vector>

#include "tests/solver/random_problems.h"

namespace palpa::bench {

/// One scene: 6000 ticks at 1 kHz, k = 800 N/m. Every tick all primitives are placed at the proxy anew, with
/// directions that turn slowly; the proxy is the exact balance of the tick before.
struct Scene {
  const char* name;
  bool one_mode;  ///< what a single mode places: point, line, or plane and line with one direction
  int primitives = 0;
  std::vector<test::Problem> ticks;
};

std::vector<Scene> scenes();

}  // namespace palpa::bench
