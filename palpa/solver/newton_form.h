// Balance in newtons: the form that is solved (solver.cpp) and proven (law.cpp). Internal.
//
// With an origin o near the proxy, all quantities are multiplied by the stiffness k once:
//     Z = k (x − o)      the unknown            C = k (probe − o) + Σ directed
//     B = k (a − o)      of each primitive      γ = c/(kT)
// and the energy of law.h, times k, is free of parameters (docs/theory.md):
//     ½|Z − C|² + Σ φ(R),   φ(R) = s|R| + γ/2 |R|²,   R = P (B − Z),
// P the projection on the primitive's span: all directions (point), the directions across q (line), q alone and one-sided
// (plane). For an elastic plane or corner with compliance c = k/κ, φ is |R|²/2c up to |R| = cs and s|R| − cs²/2 beyond, and
// φ*(u) = c|u|²/2 for |u| ≤ s. At the balance Z = C + Σu, with u the forces, each in the subdifferential of φ at R.
#pragma once

#include <limits>

#include "palpa/solver/corner.h"

namespace palpa::detail {

inline constexpr double epsilon = std::numeric_limits<double>::epsilon();  // one rounding is at most half of it

inline double size_of(const Vec3& v) noexcept { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

// A smaller γ counts as zero: its force is below rounding beside the coupling's, and is included in `slack`; larger values
// would widen the bound.
inline constexpr double smallest_gamma = 1e-20;

inline double gamma_of(const Primitive& p, double k, double T) noexcept {
  const double gamma = p.drag_ns_per_m > 0.0 ? p.drag_ns_per_m / (k * std::max(T, shortest_time_s)) : 0.0;
  return gamma < smallest_gamma ? 0.0 : gamma;
}

inline double compliance_of(const Primitive& p, double k) noexcept { return p.is_elastic() ? k / p.stiffness_n_per_m : 0.0; }

enum class State : std::uint8_t { stick, slip, off };

/// A point or a line. A point is a line without direction: P v = v − (q·v) q with q = 0. The anchor of a line is slid along it
/// to the point nearest the origin, so that B has no component along q.
struct Span {
  Vec3 q, B, u;
  double s = 0.0, gamma = 0.0;
  double size = 0.0;         // of k (a − o), for the rounding of B
  std::uint32_t index = 0;   // in the set
  State state = State::off;  // in the active set
  Vec3 R = {};               // in the active set

  Vec3 across(const Vec3& v) const noexcept { return v - dot(q, v) * q; }
  Vec3 residual(const Vec3& Z) const noexcept { return across(B - Z); }
};

/// A plane: acts along q alone, so b = q·B, r = b − q·Z and u = t q.
struct Plane {
  Vec3 q;
  double b = 0.0, t = 0.0, s = 0.0, gamma = 0.0;
  double size = 0.0;  // of B, for the rounding of b
  std::uint32_t index = 0;
  State state = State::off;
  double r = 0.0;
  double compliance = 0.0;
  double rest = 1.0;  // 1/(1 + cτ) of the active set's τ

  double residual(const Vec3& Z) const noexcept { return b - dot(q, Z); }
};

// Rounding of a residual, in ε times the sizes of its terms: k (a − o) costs 1, a product with q 1.5 and the difference ½; q
// itself is of unit length to 2 ε, which costs 2 for a plane; a line subtracts its component along q twice, from B and from B −
// Z.
inline constexpr double plane_rounding = 5.0 * epsilon;
inline constexpr double span_rounding = 8.0 * epsilon;

/// Contribution of a primitive to the duality gap  g = φ(R) + φ*(u) − u·R ≥ 0,  φ*(u) = (|u| − s)₊²/(2γ).
///
/// g is a difference of nearly equal terms, so it is never computed by subtraction. With l = min(|u|, s), m = (|u| − s)₊/γ and
/// e = u/|u| it is a sum of products of non-negative factors:
///   point, line:  (s − l)|R| + l (|R| − e·R) + γ/2 |R − m e|²,   |R| − e·R = |e × R|²/(|R| + e·R)
///   plane:        (s − l) r₊ + |u| r₋ + γ/2 (r₊ − m)²
///   elastic, with v = min(|R|/c, s) its exact force:  (v − |u|) (|R| − c (v + |u|)/2) + (|u||R| − u·R)
/// and each factor is raised by its rounding. The proof is about an exactly admissible force, with length exactly s + γ|R|
/// where u has it but for rounding: `slack` away from u.
struct Gap {
  double plain = 0.0;    // [N²] as computed
  double rounded = 0.0;  // [N²] upper bound, rounding included
  double slack = 0.0;    // [N]
};

// [1] Up to this γ a force that is right to rounding is taken as exact. Above, γ times the rounding of R would be too large:
// the last term is computed.
inline constexpr double largest_exact_gamma = 1.0;

// Gap of an elastic primitive: |R| = `reach`, off by `delta`, and a force of length `t` along R. φ has a slope of at most s and
// a curvature of at most 1/c, which bounds the rounding.
inline Gap elastic_gap(double reach, double delta, double t, double s, double c) noexcept {
  const double v = std::min(std::max(0.0, reach) / c, s);
  delta += 4.0 * epsilon * (std::abs(reach) + c * (v + t));
  const double miss = std::abs(v - t) + 2.0 * epsilon * (v + t);
  Gap gap;
  gap.plain = v < s && reach >= 0.0 ? 0.5 * (reach - c * t) * ((reach - c * t) / c) : (v - t) * (reach - 0.5 * c * (v + t));
  gap.plain = std::max(0.0, gap.plain);
  gap.rounded = gap.plain * (1.0 + 8.0 * epsilon) + delta * std::min(miss + 0.5 * delta / c, std::max(s, t) + miss);
  gap.slack = 3.0 * epsilon * t;
  return gap;
}

inline Gap gap(const Plane& p, const Vec3& Z, double size_of_Z) noexcept {
  const double r = p.residual(Z);
  const double delta = plane_rounding * (p.size + size_of_Z);
  if (p.compliance > 0.0) return elastic_gap(r, delta, p.t, p.s, p.compliance);
  const double behind = std::max(0.0, r), before = std::max(0.0, -r);
  const double raised_behind = std::max(0.0, r + delta), raised_before = std::max(0.0, delta - r);
  const double given = p.s + p.gamma * behind;
  Gap gap;
  gap.slack = 3.0 * epsilon * p.t + smallest_gamma * (behind + delta);
  if (p.gamma <= largest_exact_gamma && std::abs(p.t - given) <= 8.0 * epsilon * given) {
    gap.slack += 8.0 * epsilon * given + p.gamma * delta;
    gap.plain = given * before;
    gap.rounded = given * raised_before;
    return gap;
  }
  const double l = std::min(p.t, p.s);
  gap.plain = (p.s - l) * behind + p.t * before;
  gap.rounded = (p.s - l) * raised_behind + p.t * raised_before;
  if (p.gamma > 0.0) {
    const double m = (p.t - l) / p.gamma;
    const double miss = std::abs(behind - m);
    const double raised = miss + delta + 4.0 * epsilon * (m + p.t / p.gamma);
    gap.plain += 0.5 * p.gamma * miss * miss;
    gap.rounded += 0.5 * p.gamma * raised * raised;
  }
  return gap;
}

// Gap without drag: u is within the ball or disc of radius s, and g = s|R| − u·R.
inline Gap gap_without_drag(const Span& p, const Vec3& Z) noexcept {
  const Vec3 D = p.B - Z;
  const Vec3 R = p.across(D);
  const double delta = span_rounding * (p.size + size_of(D));
  const double reach = std::sqrt(norm_squared(R));
  const double pull = dot(p.u, R);
  Gap gap;
  gap.slack = 8.0 * epsilon * p.s + std::abs(dot(p.q, p.u)) + smallest_gamma * (reach + delta);
  if (norm_squared(p.u) >= (1.0 - 16.0 * epsilon) * (p.s * p.s)) {
    // Exactly s but for rounding: the remaining error is the angle between the force and R.
    gap.slack += 12.0 * epsilon * p.s;
    if (pull > 0.0 && reach > 4.0 * delta) {
      const double off = norm_squared(cross(p.u, R));
      const double raise = p.s * (delta + 8.0 * epsilon * reach);
      gap.plain = off / (p.s * reach + pull);
      gap.rounded = (1.25 * off + 5.0 * raise * raise) / (p.s * (reach - 4.0 * delta) + pull);
      return gap;
    }
  }
  gap.plain = std::max(0.0, p.s * reach - pull);
  gap.rounded = gap.plain + p.s * (2.0 * delta + 8.0 * epsilon * reach);
  return gap;
}

inline Gap gap(const Span& p, const Vec3& Z) noexcept {
  if (p.gamma == 0.0) return gap_without_drag(p, Z);
  const Vec3 D = p.B - Z;
  const Vec3 R = p.across(D);
  const double delta = span_rounding * (p.size + size_of(D));
  const double reach = norm(R);
  const double length = norm(p.u);
  const double given = p.s + p.gamma * reach;
  const bool exact = p.gamma <= largest_exact_gamma && std::abs(length - given) <= 16.0 * epsilon * given;
  const double l = exact ? given : std::min(length, p.s);
  Gap gap;
  gap.slack = 8.0 * epsilon * length + std::abs(dot(p.q, p.u));
  if (exact) {
    gap.slack += 16.0 * epsilon * given + p.gamma * delta;
  } else {
    gap.plain = (p.s - l) * reach;
    gap.rounded = (p.s - l) * (reach + delta);
  }
  if (l > 0.0) {
    const double along = dot(p.u, R) / length;
    if (along > 0.0 && reach > 4.0 * delta) {
      const double off = norm(cross(p.u, R)) / length;
      const double raised = off + delta + 8.0 * epsilon * reach;
      gap.plain += l * off * (off / (reach + along));
      gap.rounded += l * raised * (raised / (reach + along - 3.0 * delta));
    } else {
      gap.plain += l * (reach - along);
      gap.rounded += l * (reach - along + 2.0 * delta);
    }
  }
  if (!exact) {
    const double m = (length - l) / p.gamma;
    const double miss = norm(R - (length > 0.0 ? m / length : 0.0) * p.u);
    const double raised = miss + delta + 8.0 * epsilon * (m + length / p.gamma);
    gap.plain += 0.5 * p.gamma * miss * miss;
    gap.rounded += 0.5 * p.gamma * raised * raised;
  }
  return gap;
}

/// A corner of two facets or more, each with b and r as a plane's. Acts within the span of a face, like a plane, a line or a
/// point, with forces t of that face's facets: u = Σ t n, |u| ≤ s.
struct Corner {
  std::span<const Vec3> normals;
  const double* b = nullptr;
  double s = 0.0;
  double compliance = 0.0;
  double rest = 1.0;        // as a plane's
  std::uint32_t index = 0;  // of its first facet, in the set
  Face face;
  double t[3] = {};
  Vec3 u;
  State state = State::off;
  Vec3 R = {};

  double residual(std::size_t i, const Vec3& Z) const noexcept { return b[i] - dot(normals[i], Z); }
  /// Pull on it through a spring of stiffness τ that starts from u: the least way for c = τ r + n·u. \param guess  of least_way
  LeastWay pull(const Vec3& Z, double tau, const Face& guess = {}) const noexcept;
  /// Sets the force for the least way of such a pull: w/(1 + cτ) up to s, else s along w.
  void answer(const LeastWay& way, double tau) noexcept;
  /// Sets the t of the face from u, projected on the admissible forces; with full strength if `slips`.
  void confine(bool slips) noexcept;
  /// Sets u to the sum of t n, |u| ≤ s: |u| = s if `full`.
  void gather(bool full) noexcept;
  /// Writes each facet's force t n, in the order of the set.
  void give(Vec3* forces_n) const noexcept;
};

/// Contribution of a corner. For any w, with v = max [r − n·w]₊ the infeasibility of Z + w and σ the corner's width,
///     g ≤ (φ(|w|) + φ*(u) − u·w) + Σ t [n·w − r]₊ + (s/σ) v
/// and w is chosen, so it has no rounding of its own: the hull of the corner's face, or of the face nearest to Z.
Gap gap(const Corner& p, const Vec3& Z) noexcept;

/// Duality gap of a point and a set of forces, summed by primitive, and its bound:
///     |Z − Z*| ≤ (ρ + √(ρ² + 4ε))/2,   ρ = |Z − C − Σu|,   ε = Σ g.
class Proof {
 public:
  /// `terms` [1]: number of terms summed to C, of `size` [N] together.
  Proof(const Vec3& Z, const Vec3& C, double size, double terms) noexcept
      : left_(Z - C), size_(size_of(Z) + size), terms_(terms) {}

  void add(const Gap& gap, const Vec3& u) noexcept {
    left_ -= u;
    size_ += size_of(u);
    slack_ += gap.slack;
    plain_ += gap.plain;
    rounded_ += gap.rounded;
    ++terms_;
  }
  /// [N] ρ: the residual force.
  double left() const noexcept { return norm(left_); }
  /// [N] of ρ.
  double rounding() const noexcept { return (4.0 + terms_) * epsilon * size_ + vanished_n; }
  /// [N] without rounding: decides whether more work would help.
  double plain_bound() const noexcept { return bound(norm(left_), plain_); }
  /// [N] rounding of all steps included.
  double bound() const noexcept {
    return bound(norm(left_) + slack_ + rounding(), rounded_) * (1.0 + (8.0 + terms_) * epsilon);
  }

 private:
  static constexpr double vanished_n = 1e-140;  // hidden by squares too small for a double
  static double bound(double rho, double gap) noexcept { return 0.5 * (rho + std::sqrt(rho * rho + 4.0 * gap)); }

  Vec3 left_;
  double size_ = 0.0, slack_ = 0.0, plain_ = 0.0, rounded_ = 0.0, terms_ = 0.0;
};

}  // namespace palpa::detail
