#include "palpa/core/solver.h"

#include <cassert>
#include <limits>

namespace palpa {

namespace {

// The bound asked for is tighter than the one claimed as exact: stopping at the claim itself left
// nearly parallel lines a little above it.
constexpr double wanted_bound_m = 2e-10;

// Sweeps come in rounds; between two rounds the forces are brought close by Newton's method. Nearly all
// sets are done within the first round; the caps bound a balance to some tens of µs per five primitives.
constexpr int sweeps_per_round = 10;
constexpr int max_rounds = 12;
constexpr int newton_steps = 30;
constexpr int line_search_steps = 30;

constexpr double stiffest_n_per_m = 1e12;
constexpr double shortest_time_s = 1e-15;

bool usable(const Vec3& position_m) noexcept {
  return is_finite(position_m) && largest_component(position_m) <= largest_position_m;
}

// The force of one primitive that answers `pull_n` through a spring of `stiffness`: u ∈ ∂φ(r) with
// r = (pull − u)/stiffness. With pull = k r it is the best force, all others held; with pull = u + τ r
// it is one step of the method of multipliers.
Vec3 answer(const Primitive& p, const Vec3& pull_n, double stiffness, double T) noexcept {
  Vec3 v = pull_n;
  if (p.kind == PrimitiveKind::line) v -= dot(p.direction, v) * p.direction;
  if (p.kind == PrimitiveKind::plane) v = std::max(0.0, dot(p.direction, v)) * p.direction;
  const double demanded = norm(v);
  if (demanded <= p.strength_n) return v;
  double given = p.strength_n;
  if (p.drag_ns_per_m > 0.0) {
    const double C = p.drag_ns_per_m / T;
    given += C * ((demanded - p.strength_n) / (stiffness + C));
  }
  return (given / demanded) * v;
}

void add_outer(Mat3& m, double f, const Vec3& e) noexcept {
  m.row[0] += (f * e.x) * e;
  m.row[1] += (f * e.y) * e;
  m.row[2] += (f * e.z) * e;
}

// τ times the derivative of `answer` with respect to the pull: within the span, 1 where it sticks; where
// it slips, C/(τ + C) along the force and |u|/|v| across it.
void add_stiffness(Mat3& H, const Primitive& p, const Vec3& pull_n, double tau, double T) noexcept {
  const Vec3& q = p.direction;
  const double C = p.drag_ns_per_m > 0.0 ? p.drag_ns_per_m / T : 0.0;
  const double along = tau * (C / (tau + C));
  if (p.kind == PrimitiveKind::plane) {
    const double v = dot(q, pull_n);
    if (v > 0.0) add_outer(H, v <= p.strength_n ? tau : along, q);
    return;
  }
  const Vec3 v = p.kind == PrimitiveKind::line ? pull_n - dot(q, pull_n) * q : pull_n;
  const double demanded = norm(v);
  double across = tau;
  if (demanded > p.strength_n) {
    const double given = p.strength_n + C * ((demanded - p.strength_n) / (tau + C));
    across = tau * (given / demanded);
    add_outer(H, along - across, v / demanded);
  }
  H.row[0].x += across, H.row[1].y += across, H.row[2].z += across;
  if (p.kind == PrimitiveKind::line) add_outer(H, -across, q);
}

// Method of multipliers with Newton's method inside: for a growing τ, minimises over y = x − start the
// convex, once differentiable
//     Ψ(y) = k/2 |y|² − C·y + Σ max_u [u·r_i(y) − φ*_i(u) − |u − u_i|²/(2τ)]
// (its gradient is k y − C − Σ answer(u_i + τ r_i)), then takes the maximising forces. Sweeps alone need
// thousands of rounds where primitives are nearly parallel or drags are much stiffer than the coupling.
// Returns the number of Newton steps.
int approach(std::span<const Primitive> primitives, Vec3* forces_n, const Vec3& start_m, const Vec3& C, double k,
             double T) noexcept {
  const std::size_t n = primitives.size();
  Vec3 y = C;
  for (std::size_t i = 0; i < n; ++i) {
    if (primitives[i].kind != PrimitiveKind::directed) y += forces_n[i];
  }
  y = y / k;
  int steps = 0;
  for (const double share : {1e2, 1e4, 1e6}) {
    const double tau = share * k;
    const auto pull = [&](std::size_t i, const Vec3& at) {
      return forces_n[i] + tau * ((primitives[i].position_m - start_m) - at);
    };
    const auto gradient = [&](const Vec3& at) {
      Vec3 g = k * at - C;
      for (std::size_t i = 0; i < n; ++i) {
        if (primitives[i].kind != PrimitiveKind::directed) g -= answer(primitives[i], pull(i, at), tau, T);
      }
      return g;
    };
    Vec3 g = gradient(y);
    for (int step = 0; step < newton_steps; ++step, ++steps) {
      Mat3 H{{{k, 0, 0}, {0, k, 0}, {0, 0, k}}};
      for (std::size_t i = 0; i < n; ++i) {
        if (primitives[i].kind != PrimitiveKind::directed) add_stiffness(H, primitives[i], pull(i, y), tau, T);
      }
      const Vec3 d = -(inverse(H) * g);
      const double slope = dot(g, d);
      if (!is_finite(d) || !(slope < 0.0) || norm(g) <= 1e-13 * (norm(C) + k * norm(y))) break;
      // Along d the slope only grows: shorten until it is past zero by less than half of what it was.
      double low = 0.0, high = 1.0, share_of_d = 1.0;
      Vec3 g_new = gradient(y + d);
      for (int i = 0; i < line_search_steps && dot(g_new, d) > -0.5 * slope; ++i) {
        high = share_of_d;
        share_of_d = 0.5 * (low + high);
        g_new = gradient(y + share_of_d * d);
        if (dot(g_new, d) < 0.0) low = share_of_d;
      }
      y += share_of_d * d;
      g = g_new;
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (primitives[i].kind != PrimitiveKind::directed) forces_n[i] = answer(primitives[i], pull(i, y), tau, T);
    }
  }
  return steps;
}

}  // namespace

Solver::Solver(std::size_t capacity)
    : capacity_(capacity),
      forces_(std::make_unique<Vec3[]>(capacity)),
      ids_(std::make_unique<PrimitiveId[]>(capacity)),
      kept_forces_(std::make_unique<Vec3[]>(capacity)),
      kept_ids_(std::make_unique<PrimitiveId[]>(capacity)) {}

Balance Solver::solve(const PrimitiveSet& set, const Vec3& start_m, const Vec3& probe_m, double k, double T) noexcept {
  assert(set.size() <= capacity_);
  const std::span<const Primitive> primitives = set.primitives();
  const std::size_t n = std::min(primitives.size(), capacity_);

  // Forces of the last balance, matched by who placed them.
  std::swap(forces_, kept_forces_);
  std::swap(ids_, kept_ids_);
  const std::size_t kept = size_;
  size_ = n;
  Vec3 directed_n;
  bool drags = false;
  for (std::size_t i = 0; i < n; ++i) {
    const Primitive& p = primitives[i];
    ids_[i] = p.id;
    forces_[i] = {};
    drags = drags || p.drag_ns_per_m > 0.0;
    if (p.kind == PrimitiveKind::directed) {
      forces_[i] = p.strength_n * p.direction;
      directed_n += forces_[i];
      continue;
    }
    for (std::size_t step = 0; step < kept; ++step) {  // the same place first: sets rarely change
      const std::size_t j = (i + step) % kept;
      if (kept_ids_[j] == p.id) {
        forces_[i] = kept_forces_[j];
        break;
      }
    }
  }

  const bool time_usable = !drags || (std::isfinite(T) && T >= shortest_time_s);
  if (!(k > 0.0) || !(k <= stiffest_n_per_m) || !time_usable || !usable(start_m) || !usable(probe_m) ||
      !is_finite(directed_n)) {
    std::fill_n(forces_.get(), n, Vec3{});
    return {usable(start_m) ? start_m : Vec3{}, std::numeric_limits<double>::max(), BalanceStatus::bad_input, 0, 0};
  }

  // In newtons, about the start: primitives placed at the proxy then sit at exactly zero.
  //   Z = k (x − start),  C = k (probe − start) + directed,  Z = C + Σu at every moment.
  const Vec3 C = k * (probe_m - start_m) + directed_n;
  Vec3 Z;
  bool only_directed = true;
  for (const Primitive& p : primitives.first(n)) only_directed = only_directed && p.kind == PrimitiveKind::directed;
  // With nothing to balance the proxy is the probe itself, to the last bit.
  if (n == 0) return {probe_m, 0.0, BalanceStatus::exact, 0, 0};

  Balance best;
  best.error_bound_m = std::numeric_limits<double>::max();
  bool best_is_last = false;
  bool done = false;
  const std::span<Vec3> forces{forces_.get(), n};
  for (int round = 0; round < max_rounds && !done; ++round) {
    best.stage = round == 0 ? 1 : 2;
    if (round > 0) best.iterations += approach(primitives.first(n), forces_.get(), start_m, C, k, T);
    for (int sweep = 1; sweep <= sweeps_per_round && !done; ++sweep) {
      // The sum anew: Z would gather rounding over the sweeps.
      Z = C;
      for (std::size_t i = 0; i < n; ++i) {
        if (primitives[i].kind != PrimitiveKind::directed) Z += forces[i];
      }
      for (std::size_t i = 0; i < n; ++i) {
        const Primitive& p = primitives[i];
        if (p.kind == PrimitiveKind::directed) continue;
        const Vec3 without = Z - forces[i];
        forces[i] = answer(p, k * (p.position_m - start_m) - without, k, T);
        Z = without + forces[i];
      }
      ++best.iterations;
      if (sweep > 3 && sweep % 3 != 1) continue;  // the certificate costs as much as a sweep
      Z = C;
      for (std::size_t i = 0; i < n; ++i) {
        if (primitives[i].kind != PrimitiveKind::directed) Z += forces[i];
      }
      const Vec3 x_m = start_m + Z / k;
      if (!is_finite(x_m)) break;
      const double bound_m = error_bound_m(primitives.first(n), forces, x_m, probe_m, k, T);
      // Rounding alone can keep the bound above what is wanted; then it stops falling.
      const bool at_floor = bound_m <= exact_bound_m && bound_m > 0.5 * best.error_bound_m;
      done = bound_m <= wanted_bound_m || at_floor || only_directed;
      best_is_last = bound_m < best.error_bound_m;
      if (best_is_last) {
        best.position_m = x_m;
        best.error_bound_m = bound_m;
        std::copy_n(forces_.get(), n, kept_forces_.get());  // the warm start has been taken: its place is free
      }
    }
  }
  if (!best_is_last) std::copy_n(kept_forces_.get(), n, forces_.get());
  best.status = best.error_bound_m <= exact_bound_m ? BalanceStatus::exact : BalanceStatus::capped;
  return best;
}

Balance solve_once(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                   double time_step_s) {
  Solver solver(std::max<std::size_t>(1, primitives.size()));
  return solver.solve(primitives, start_m, probe_m, stiffness_n_per_m, time_step_s);
}

}  // namespace palpa
