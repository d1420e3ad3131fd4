// Two of three readings of the paper's sentence "the new proxy position is then found by minimizing the residual force using an
// adaptive step-length numerical solver". The third is the law of the library; these two show the reason for it.
#pragma once

#include <span>

#include "palpa/solver/primitives.h"

namespace palpa::test {

enum class Reading {
  residual_falls,  ///< a step counts if |f_res| falls
  energy_falls,    ///< a step counts if the energy falls whose gradient is −f_res
};

struct Posed {
  std::span<const Primitive> primitives;
  Vec3 start_m;
  Vec3 probe_m;
  double k = 0.0;
  double T = 0.0;
};

inline Vec3 printed_residual_n(const Posed& posed, const Vec3& x) {
  Vec3 f = -posed.k * (x - posed.probe_m);
  for (const Primitive& p : posed.primitives) {
    if (p.kind == PrimitiveKind::directed) {
      f += p.strength_n * p.direction;
      continue;
    }
    const Vec3 r = residual(p, x);
    if (norm(r) > 0.0) f += p.strength_n * normalized(r) + (p.drag_ns_per_m / posed.T) * r;
  }
  return f;
}

inline double energy_j(const Posed& posed, const Vec3& x) {
  double e = 0.5 * posed.k * norm_squared(x - posed.probe_m);
  for (const Primitive& p : posed.primitives) {
    if (p.kind == PrimitiveKind::directed) {
      e -= p.strength_n * dot(p.direction, x - posed.start_m);
      continue;
    }
    const double r = norm(residual(p, x));
    e += p.strength_n * r + 0.5 * p.drag_ns_per_m / posed.T * r * r;
  }
  return e;
}

/// The proxy after at most `most_steps` steps x + h f_res(x); the first h is the reciprocal of the sum of the slopes of
/// coupling and drags.
inline Vec3 proxy_by(Reading reading, const Posed& posed, int most_steps) {
  Vec3 x = posed.start_m;
  Vec3 f = printed_residual_n(posed, x);
  double e = energy_j(posed, x);
  double slope_n_per_m = posed.k;
  for (const Primitive& p : posed.primitives) {
    if (p.drag_ns_per_m > 0.0) slope_n_per_m += p.drag_ns_per_m / posed.T;
  }
  double h = 1.0 / slope_n_per_m;
  for (int step = 0; step < most_steps && h * norm(f) > 1e-12; ++step) {
    const Vec3 tried = x + h * f;
    const Vec3 f_tried = printed_residual_n(posed, tried);
    const double e_tried = energy_j(posed, tried);
    const bool better = reading == Reading::residual_falls ? norm(f_tried) < norm(f) : e_tried < e;
    if (better) x = tried, f = f_tried, e = e_tried;
    h *= better ? 1.1 : 0.5;
  }
  return x;
}

}  // namespace palpa::test
