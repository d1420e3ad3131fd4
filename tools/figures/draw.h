// Random numbers of the figures.
#pragma once

#include <cstddef>
#include <random>

#include "palpa/solver/vec3.h"

namespace palpa {

/// The same numbers on every machine: the standard distributions differ between libraries.
class Draw {
 public:
  explicit Draw(unsigned seed) : bits_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53; }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(uniform(0.0, static_cast<double>(count))); }
  Vec3 in_cube(double half) {
    const double x = uniform(-half, half), y = uniform(-half, half), z = uniform(-half, half);
    return {x, y, z};
  }
  Vec3 direction() {
    for (;;) {
      const Vec3 v = in_cube(1.0);
      if (norm(v) > 0.1 && norm(v) < 1.0) return normalized(v);
    }
  }

 private:
  std::mt19937_64 bits_;
};

}  // namespace palpa
