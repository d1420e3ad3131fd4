// Random balance problems for the tests, identical on every machine.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "palpa/solver/primitives.h"

namespace palpa::test {

/// A small generator of its own: the standard distributions differ between libraries.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ull + 1) {}
  std::uint64_t bits() {
    state_ ^= state_ << 13, state_ ^= state_ >> 7, state_ ^= state_ << 17;
    return state_ * 0x2545F4914F6CDD1Dull;
  }
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53; }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  int below(int n) { return static_cast<int>(bits() % static_cast<std::uint64_t>(n)); }
  Vec3 in_cube(double half) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }
  Vec3 direction() {
    for (;;) {
      const Vec3 v = in_cube(1.0);
      const double n = norm(v);
      if (n > 0.1 && n < 1.0) return normalized(v);
    }
  }
  Mat3 rotation() {
    const Vec3 a = direction();
    const Vec3 b = normalized(cross(a, direction()));
    return transposed({{a, b, cross(a, b)}});
  }

 private:
  std::uint64_t state_;
};

struct Problem {
  std::vector<Primitive> primitives;
  Vec3 start_m;
  Vec3 probe_m;
  double stiffness_n_per_m = 800.0;
  double time_step_s = 1e-3;
};

inline PrimitiveKind random_kind(Random& random) { return static_cast<PrimitiveKind>(random.below(4)); }

/// Primitives at the proxy or a little off it, with strengths of up to 5 N; drags only at the proxy.
inline Problem random_problem(Random& random, int n, bool drags) {
  Problem problem;
  problem.start_m = random.in_cube(0.05);
  problem.probe_m = problem.start_m + random.in_cube(0.004);
  problem.stiffness_n_per_m = random.uniform(300, 3000);
  for (int i = 0; i < n; ++i) {
    Primitive p;
    p.kind = random_kind(random);
    p.id.slot = static_cast<std::uint16_t>(i);
    const bool at_proxy = random.below(2) == 0;
    p.position_m = problem.start_m + (at_proxy ? Vec3{} : random.in_cube(0.003));
    p.direction = random.direction();
    p.strength_n = random.uniform(0, p.kind == PrimitiveKind::directed ? 1.0 : 5.0);
    if (drags && at_proxy && p.kind != PrimitiveKind::directed && random.below(2) == 0) p.drag_ns_per_m = random.uniform(0, 20);
    problem.primitives.push_back(p);
  }
  return problem;
}

inline void fill(PrimitiveSet& set, const Problem& problem) {
  set.clear(problem.start_m);
  for (const Primitive& p : problem.primitives) set.add(p);
}

}  // namespace palpa::test
