#include "palpa/session/sub_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpa/solver/pose_solver.h"

namespace palpa {

Vec3 foot_way_m(const SubStep& step, const PlacedPrimitive& placed) noexcept {
  const Vec3 way_m = step.proxy_m - step.start_m;
  if (placed.lever_m == Vec3{}) return way_m;
  return way_m + cross(rotation_between_rad(step.start_turn, step.proxy_turn), placed.lever_m);
}

double work_j(const SubStep& step, const PlacedPrimitive& placed) noexcept {
  return dot(placed.force_n, foot_way_m(step, placed) - step.move_fraction * placed.carried_m);
}

namespace {

// Largest change of the gap of a primitive, or of a corner that pushes with `force_n`, with its residual [N].
double gap_slope_n(const PlacedPrimitive& placed, const Vec3& force_n, const Vec3& foot_m, double error_bound_m, double k,
                   double T, double rounding_m) noexcept {
  if (placed.state == PrimitiveState::off) return 0.0;
  const Primitive& p = placed.primitive;
  const bool slips = placed.state == PrimitiveState::slip;  // its direction is as accurate as the path is long
  const double share = slips ? std::min(1.0, rounding_m / norm(residual(p, foot_m))) : 1.0;
  // Of a plane, behind it the missing part of the force is wrong, in front of it all of the force.
  const double s = p.strength_n, u = norm(force_n);
  double slope_n = p.kind == PrimitiveKind::plane ? std::max(s - u, u) : s + u;
  // The force of an elastic primitive is wrong by no more than its bound and that rounding allow (theory.md 8.12).
  const double stiffness = p.stiffness_n_per_m;
  if (p.is_elastic()) slope_n = std::min(slope_n, std::sqrt(2.0 * stiffness * k) * error_bound_m + stiffness * rounding_m);
  slope_n *= share;
  // So is a drag's, and it bends with the stiffness of the drag (theory.md 3.5).
  if (p.drag_ns_per_m > 0.0) {
    const double C = p.drag_ns_per_m / std::max(T, shortest_time_s);
    slope_n += std::sqrt(2.0 * C * k) * error_bound_m + 0.5 * C * rounding_m;
  }
  return slope_n;
}

}  // namespace

double recorded_bound_m(std::span<const PlacedPrimitive> placed, const Balance& balance, double stiffness_n_per_m,
                        double time_step_s, double turning_radius_m) noexcept {
  const double k = stiffness_n_per_m;
  const auto size_of = [](const Vec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  const bool is_tool = turning_radius_m > 0.0;
  double slope_n = 0.0;
  Vec3 corner_n;  // its facets press together, with a single strength
  // A tool's motion from its start is recorded: its rounding is that of a small number, times the longest lever.
  double reach_m = 0.0;
  for (std::size_t i = 0; is_tool && i < placed.size(); ++i) reach_m = std::max(reach_m, size_of(placed[i].lever_m));
  const double rounding_m = is_tool ? 2.0 * epsilon * (size_of(balance.way_m) + reach_m * size_of(balance.turn_rad))
                                    : 0.5 * epsilon * size_of(balance.position_m);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    corner_n += placed[i].force_n;
    if (i + 1 < placed.size() && placed[i + 1].primitive.id == placed[i].primitive.id) continue;
    Vec3 foot_m = balance.position_m;
    double foot_bound_m = balance.error_bound_m;
    if (is_tool) {
      const Balance at = balance_at_foot(balance, placed[i].lever_m, turning_radius_m);
      foot_m = at.position_m, foot_bound_m = at.error_bound_m;
    }
    slope_n += gap_slope_n(placed[i], corner_n, foot_m, foot_bound_m, k, time_step_s, rounding_m);
    corner_n = {};
  }
  // A bound b = (ρ + √(ρ² + 4kε)) / 2k has ρ ≤ kb; with e more of gap it is at most (b + √(b² + 4e/k)) / 2.
  const double b = balance.error_bound_m;
  const double bound_m = 0.5 * (b + std::sqrt(b * b + 4.0 * slope_n * rounding_m / k));
  return std::min(bound_m, std::numeric_limits<double>::max());  // also for a balance without a bound
}

namespace {

// Adds what a tool's turn changes.
[[gnu::noinline]] void complete_turn(SubStep& step, std::span<const PlacedPrimitive> placed) noexcept {
  const double kappa = step.stiffness_n_per_m * step.turning_radius_m * step.turning_radius_m;
  const auto turned_j = [&](const Turn& turn) {
    return 0.5 * kappa * norm_squared(rotation_between_rad(turn, step.probe_turn));
  };
  step.energy_before_j += turned_j(step.start_turn);
  step.energy_after_j += turned_j(step.proxy_turn);
  for (const PlacedPrimitive& row : placed) {
    if (row.primitive.kind == PrimitiveKind::directed)
      step.energy_after_j -= dot(row.force_n, foot_way_m(step, row) - (step.proxy_m - step.start_m));
  }
}

}  // namespace

void complete(SubStep& step, std::span<const PlacedPrimitive> placed) noexcept {
  const double k = step.stiffness_n_per_m;
  double& bound_m = step.balance.error_bound_m;
  if (!placed.empty()) bound_m = recorded_bound_m(placed, step.balance, k, step.time_step_s, step.turning_radius_m);
  if (step.balance.status == BalanceStatus::exact && bound_m > exact_bound_m) step.balance.status = BalanceStatus::capped;
  const auto energy_j = [&](const Vec3& x) {
    return 0.5 * k * norm_squared(x - step.probe_m) - dot(step.directed_n, x - step.start_m);
  };
  step.energy_before_j = energy_j(step.start_m);
  step.energy_after_j = energy_j(step.proxy_m);
  if (step.turning_radius_m > 0.0) complete_turn(step, placed);
}

}  // namespace palpa
