#include "palpa/baseline/paper_2005.h"

namespace palpa::baseline {

namespace {

// All our reading; the errors in docs/laws.md were measured with these values.
constexpr int most_steps = 200;            // [1] More: a longer worst case; fewer: it stops short of the balance
constexpr double shortest_step_m = 1e-12;  // ends the search. Longer: it ends early; shorter: steps of rounding alone
constexpr double growth = 1.1;             // [1] of h while f_res keeps its direction. More: it turns more often; less: slow
constexpr int force_sweeps = 10;           // [1] for the returned forces. More: slower; fewer: a larger proven bound

}  // namespace

EarlierLaw::Moved Paper2005::move(const Posed& posed, std::span<Vec3> forces_n) noexcept {
  const double k = posed.stiffness_n_per_m;
  const double T = posed.time_step_s;
  const auto residual_n = [&](const Vec3& x) {
    Vec3 f = k * (posed.target_m - x);
    for (const Primitive& p : posed.primitives) {
      const Vec3 r = residual(p, x);
      if (norm_squared(r) == 0.0) continue;
      f += p.strength_n * normalized(r);
      if (p.drag_ns_per_m > 0.0) f += (p.drag_ns_per_m / T) * r;
    }
    return f;
  };

  double slope_n_per_m = k;
  for (const Primitive& p : posed.primitives) {
    if (p.drag_ns_per_m > 0.0) slope_n_per_m += p.drag_ns_per_m / T;
  }
  double h = 1.0 / slope_n_per_m;
  Moved moved{posed.start_m, 0};
  Vec3 f = residual_n(moved.proxy_m);
  while (moved.iterations < most_steps && h * norm(f) > shortest_step_m) {
    ++moved.iterations;
    moved.proxy_m += h * f;
    const Vec3 f_before = f;
    f = residual_n(moved.proxy_m);
    h *= dot(f, f_before) < 0.0 ? 0.5 : growth;
  }

  Vec3 sum_n;
  for (int sweep = 0; sweep < force_sweeps; ++sweep) {
    for (std::size_t i = 0; i < posed.primitives.size(); ++i) {
      const Primitive& p = posed.primitives[i];
      if (p.kind == PrimitiveKind::directed) continue;
      const Vec3 others_n = sum_n - forces_n[i];
      forces_n[i] = answer_n(p, k * (p.position_m - posed.target_m) - others_n, k, T);
      sum_n = others_n + forces_n[i];
    }
  }
  return moved;
}

}  // namespace palpa::baseline
