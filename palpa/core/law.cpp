#include "palpa/core/law.h"

#include <limits>

namespace palpa {

namespace {

constexpr double ulp = std::numeric_limits<double>::epsilon();

// One primitive's share of the duality gap, and the force that is used for it.
//
//   gap = φ(r) + φ*(u) − u·r  ≥ 0,   φ(r) = s|r| + C/2 |r|²,   C = c/T,   φ*(u) = (|u| − s)₊²/(2C)
//
// is a difference of terms that are nearly equal at the balance, so it is never computed as one. With
// l = min(|u|, s), m = (|u| − s)₊/C, e = u/|u|, and α the chord between the unit vectors of u and r:
//   point, line:  (s − l)|r| + l|r| α²/2 + C/2 |r − m e|²
//   plane:        (s − l) r₊ + |u| r₋ + C/2 (r₊ − m)²       r = q·(a − x), r₊ and r₋ its two sides
// Every term is a product of non-negative factors; each factor is raised by its rounding (η, δ), so the
// sum is a bound of the exact gap of a force u' that differs from u by a few ulp (`slack_n`).
struct Share {
  Vec3 force_n;
  double gap_nm = 0.0;   // [N·m]
  double slack_n = 0.0;  // [N]
};

Share share_of(const Primitive& p, const Vec3& x, const Vec3& force_n, double T) noexcept {
  const double s = p.strength_n;
  const double C = p.drag_ns_per_m > 0.0 ? p.drag_ns_per_m / T : 0.0;
  const Vec3& q = p.direction;
  const Vec3 d = p.position_m - x;

  Share share;
  Vec3 u = force_n;
  if (p.kind == PrimitiveKind::line) u -= dot(q, u) * q;
  if (p.kind == PrimitiveKind::plane) u = std::max(0.0, dot(q, u)) * q;
  double length = norm(u);
  if (C == 0.0 && length > s) {
    u = (s / length) * u;
    length = s;
  }
  share.force_n = u;
  share.slack_n = 4.0 * ulp * (length + norm(force_n));
  if (std::abs(length - s) <= 8.0 * ulp * s) {  // u' is as long as s: what is missing is left over
    share.slack_n += 8.0 * ulp * s;
    length = s;
  }
  const double l = std::min(length, s);
  const double excess = length - l;
  const double m = C > 0.0 ? excess / C : 0.0;
  const double delta_m = C > 0.0 ? 4.0 * ulp * (m + length / C) : 0.0;

  if (p.kind == PrimitiveKind::plane) {
    const double r = dot(q, d);
    const double delta = 4.0 * ulp * norm(d);
    const double behind = std::max(0.0, r + delta);
    const double before = std::max(0.0, delta - r);
    share.gap_nm = (s - l) * behind + length * before;
    if (C > 0.0) {
      const double miss = std::abs(std::max(0.0, r) - m) + delta + delta_m;
      share.gap_nm += 0.5 * C * miss * miss;
    }
    return share;
  }
  const Vec3 r = p.kind == PrimitiveKind::line ? d - dot(q, d) * q : d;
  const double reach = norm(r);
  const double delta = 4.0 * ulp * (p.kind == PrimitiveKind::line ? norm(d) : reach);
  share.gap_nm = (s - l) * (reach + delta);
  if (l > 0.0 && reach > 0.0) {
    const double eta = 8.0 * ulp + 2.0 * delta / reach;
    const double alpha = std::min(2.0, norm(u / norm(u) - r / reach) + eta);
    share.gap_nm += 0.5 * l * (reach + delta) * alpha * alpha;
  } else {
    share.gap_nm += 2.0 * l * delta;
  }
  if (C > 0.0) {
    const Vec3 e = length > 0.0 ? u / norm(u) : Vec3{};
    const double miss = norm(r - m * e) + delta + delta_m;
    share.gap_nm += 0.5 * C * miss * miss;
  }
  return share;
}

}  // namespace

const char* name_of(BalanceStatus status) noexcept {
  switch (status) {
    case BalanceStatus::exact: return "exact";
    case BalanceStatus::capped: return "capped";
    case BalanceStatus::bad_input: return "bad_input";
    case BalanceStatus::baseline: return "baseline";
  }
  return "?";
}

PrimitiveState state_at(const Primitive& primitive, const Balance& balance) noexcept {
  if (primitive.kind == PrimitiveKind::directed) return PrimitiveState::off;
  const Vec3 d = primitive.position_m - balance.position_m;
  const double tolerance =
      balance.error_bound_m + 8.0 * ulp * (largest_component(primitive.position_m) + largest_component(balance.position_m));
  if (primitive.kind == PrimitiveKind::plane) {
    const double behind = dot(primitive.direction, d);
    if (behind > tolerance) return PrimitiveState::slip;
    return behind < -tolerance ? PrimitiveState::off : PrimitiveState::stick;
  }
  return norm(residual(primitive, balance.position_m)) > tolerance ? PrimitiveState::slip : PrimitiveState::stick;
}

double error_bound_m(std::span<const Primitive> primitives, std::span<const Vec3> forces_n, const Vec3& x_m,
                     const Vec3& probe_m, double stiffness_n_per_m, double time_step_s) noexcept {
  const double k = stiffness_n_per_m;
  const Vec3 pull_n = k * (x_m - probe_m);
  Vec3 left_n = pull_n;
  double size_n = norm(pull_n);  // of all terms: what the rounding of their sum goes with
  double slack_n = 0.0;
  double gap_nm = 0.0;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    Share share;
    if (primitives[i].kind == PrimitiveKind::directed) {
      share.force_n = primitives[i].strength_n * primitives[i].direction;
    } else {
      share = share_of(primitives[i], x_m, forces_n[i], time_step_s);
    }
    left_n -= share.force_n;
    size_n += norm(share.force_n);
    slack_n += share.slack_n;
    gap_nm += share.gap_nm;
  }
  const double n = static_cast<double>(primitives.size());
  const double rho = norm(left_n) + slack_n + (4.0 + n) * ulp * size_n;
  const double bound = (rho + std::sqrt(rho * rho + 4.0 * k * gap_nm)) / (2.0 * k) * (1.0 + (8.0 + n) * ulp);
  return std::isfinite(bound) ? bound : std::numeric_limits<double>::max();
}

}  // namespace palpa
