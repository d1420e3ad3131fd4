#include "palpa/core/solver.h"

#include <cassert>
#include <limits>

namespace palpa {

namespace {

// The bound asked for is tighter than the one claimed as exact: stopping at the claim itself left
// nearly parallel lines a little above it.
constexpr double wanted_bound_m = 2e-10;

// One sweep over five primitives takes about 0.1 µs, so the cap bounds a balance to a few tens of µs
// per five primitives. Two planes at 10° need about 900 sweeps; what the cap leaves is in the bound.
constexpr int max_sweeps = 1000;

constexpr double stiffest_n_per_m = 1e12;
constexpr double shortest_time_s = 1e-15;

bool usable(const Vec3& position_m) noexcept { return is_finite(position_m) && largest_component(position_m) <= largest_position_m; }

// The best force of one primitive, all others held: `bring_n` is k·r, the force that would bring the
// proxy onto it, within its span.
Vec3 best_force(const Primitive& p, const Vec3& bring_n, double k, double T) noexcept {
  Vec3 v = bring_n;
  if (p.kind == PrimitiveKind::line) v -= dot(p.direction, v) * p.direction;
  if (p.kind == PrimitiveKind::plane) v = std::max(0.0, dot(p.direction, v)) * p.direction;
  const double demanded = norm(v);
  if (demanded <= p.strength_n) return v;
  double given = p.strength_n;
  if (p.drag_ns_per_m > 0.0) {
    const double C = p.drag_ns_per_m / T;
    given += C * ((demanded - p.strength_n) / (k + C));
  }
  return (given / demanded) * v;
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
  if (!(k > 0.0) || !(k <= stiffest_n_per_m) || !time_usable || !usable(start_m) || !usable(probe_m) || !is_finite(directed_n)) {
    std::fill_n(forces_.get(), n, Vec3{});
    return {usable(start_m) ? start_m : Vec3{}, std::numeric_limits<double>::max(), BalanceStatus::bad_input, 0, 0};
  }

  // In newtons, about the start: primitives placed at the proxy then sit at exactly zero.
  //   Z = k (x − start),  C = k (probe − start) + directed,  Z = C + Σu at every moment.
  const Vec3 C = k * (probe_m - start_m) + directed_n;
  Vec3 Z = C;
  bool only_directed = true;
  for (std::size_t i = 0; i < n; ++i) {
    if (primitives[i].kind == PrimitiveKind::directed) continue;
    only_directed = false;
    Z += forces_[i];
  }
  // With nothing to balance the proxy is the probe itself, to the last bit.
  if (n == 0) return {probe_m, 0.0, BalanceStatus::exact, 0, 0};

  Balance best;
  best.error_bound_m = std::numeric_limits<double>::max();
  best.stage = 1;
  int next_check = 1;
  int best_sweep = 0;
  for (int sweep = 1; sweep <= max_sweeps; ++sweep) {
    for (std::size_t i = 0; i < n; ++i) {
      const Primitive& p = primitives[i];
      if (p.kind == PrimitiveKind::directed) continue;
      const Vec3 without = Z - forces_[i];
      const Vec3 bring_n = k * (p.position_m - start_m) - without;
      forces_[i] = best_force(p, bring_n, k, T);
      Z = without + forces_[i];
    }
    if (sweep < next_check && !only_directed) continue;
    next_check = sweep < 4 ? sweep + 1 : sweep + sweep / 4;
    // Z gathered rounding over the sweep; the sum anew has only its own.
    Z = C;
    for (std::size_t i = 0; i < n; ++i) {
      if (primitives[i].kind != PrimitiveKind::directed) Z += forces_[i];
    }
    const Vec3 x_m = start_m + Z / k;
    if (!is_finite(x_m)) break;
    const double bound_m = error_bound_m(primitives.first(n), {forces_.get(), n}, x_m, probe_m, k, T);
    best.iterations = sweep;
    // Rounding alone can keep the bound above what is wanted; then it stops falling.
    const bool at_floor = bound_m <= exact_bound_m && bound_m > 0.5 * best.error_bound_m;
    if (bound_m < best.error_bound_m || sweep == 1) {
      best.position_m = x_m;
      best.error_bound_m = bound_m;
      best_sweep = sweep;
      std::copy_n(forces_.get(), n, kept_forces_.get());  // the warm start has been taken: its place is free
    }
    if (bound_m <= wanted_bound_m || at_floor || only_directed) break;
  }
  if (best_sweep != best.iterations) std::copy_n(kept_forces_.get(), n, forces_.get());
  best.status = best.error_bound_m <= exact_bound_m ? BalanceStatus::exact : BalanceStatus::capped;
  return best;
}

Balance solve_once(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                   double time_step_s) {
  Solver solver(std::max<std::size_t>(1, primitives.size()));
  return solver.solve(primitives, start_m, probe_m, stiffness_n_per_m, time_step_s);
}

}  // namespace palpa
