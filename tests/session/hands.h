// Hand motions for the tests of the tick.
#pragma once

#include <cmath>
#include <numbers>

#include "palpa/solver/vec3.h"
#include "tests/solver/random_problems.h"

namespace palpa::test {

/// A smooth random motion around the origin, like a hand's: a few sines below 8 Hz per axis.
class Wander {
 public:
  Wander(Random& random, double reach_m) : reach_m_(reach_m) {
    for (auto& axis : sines_) {
      for (Sine& sine : axis)
        sine = {random.uniform(0.2, 4.0), random.uniform(0, 2 * std::numbers::pi), random.uniform(0.2, 1.0)};
    }
  }
  Vec3 at(double t_s) const {
    double p[3];
    for (int a = 0; a < 3; ++a) {
      p[a] = 0.0;
      double weight = 0.0;
      for (const Sine& s : sines_[a])
        p[a] += s.weight * std::sin(2 * std::numbers::pi * s.hz * t_s + s.phase), weight += s.weight;
      p[a] *= reach_m_ / weight;
    }
    return {p[0], p[1], p[2]};
  }

 private:
  struct Sine {
    double hz, phase, weight;
  };
  Sine sines_[3][3];
  double reach_m_;
};

}  // namespace palpa::test
