// State of one balance, and the stages that find it (docs/theory.md 5). Internal to the solver.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>

#include "palpa/solver/double2.h"
#include "palpa/solver/newton_form.h"
#include "palpa/solver/solver.h"

namespace palpa {

namespace detail::solving {

using detail::Corner;
using detail::epsilon;
using detail::gap;
using detail::Plane;
using detail::Proof;
using detail::size_of;
using detail::Span;
using detail::State;

// [m] Target bound, tighter than `exact_bound_m`. Larger: nearly parallel lines stay a little above the claim; smaller: more
// rounds, in the end for rounding.
inline constexpr double wanted_bound_m = 2e-10;

// [1] Residual force at which refining ends, as a share of k times the target bound. Less: more refinements; more: it nears
// `seen_share`.
inline constexpr double refined_share = 8e-6;
// [1] Residual force in a result, likewise. Less: more rounds; more: visible in a sum of the forces.
inline constexpr double seen_share = 1e-3;
// [1] Bound, in target bounds, below which common points join the balance. Less: the rounding of their closed form is kept
// longer; more: the closed form is dropped sooner.
inline constexpr double near_share = 100.0;

// [1] In squared target bounds: rounding that a closed form may leave in the duality gap. Less: the stages run where a sweep
// would do; more: visible in a check by the gap, which takes its root.
inline constexpr double shown_by_root = 9.0;

// [1] Caps. More: a longer worst case; fewer: more balances end with a later stage, or as `capped`. Nearly all balances need
// one round; the multipliers converge within five penalties, later only the bound is slow.
inline constexpr int max_rounds = 10;
inline constexpr int max_rounds_in_vain = 2;      // rounds that do not halve the bound, before the multipliers
inline constexpr std::size_t many = 12;           // primitives: above this, a single such round is enough
inline constexpr int max_steps_in_a_round = 3;    // of the active set, before a proof
inline constexpr int max_rounds_from_before = 2;  // warm start
inline constexpr int max_refinements = 8;         // of one active-set step, with constant M
inline constexpr int max_penalties = 20;
inline constexpr int max_newton_steps = 30;  // at one penalty
inline constexpr int max_search_steps = 60;  // along one Newton step

// [1] A refinement that leaves more of the force than this share is slow: M is rebuilt. Less: more factorisations; more: more
// refinements.
inline constexpr double slow_share = 0.05;

// [1] τ of the active set: the spring that demands R = 0 of a sticking primitive. Softer: more refinements; stiffer: M loses
// digits. An elastic primitive demands R = cu instead: its spring is τ/(1 + cτ), and 1/(1 + cτ) of its demand is left after a
// move.
inline constexpr double spring = 1e8;
inline double rest_of_spring(double compliance) noexcept { return compliance > 0.0 ? 1.0 / (1.0 + compliance * spring) : 1.0; }

// [1] First penalty; each is ten times its predecessor. Lower: more penalties; higher: Newton's method may fail from afar.
inline constexpr double first_penalty = 1e3;
// [1] Up to this penalty a failed Newton method restarts with a hundredth of it, above with its result. Lower: poor minima are
// used; higher: more penalties.
inline constexpr double unsteady_penalty = 1e6;
// [1] From this penalty on the states are clear enough for the active set. Lower: it tries in vain; higher: the last digits
// cost more penalties.
inline constexpr double steady_penalty = 1e8;
// [1] Higher: M loses digits; lower: the last digits are not reached.
inline constexpr double largest_penalty = 1e14;

/// M = I + Σ stiffness, symmetric, M ≥ I.
struct Stiffness {
  double xx = 1.0, xy = 0.0, xz = 0.0, yy = 1.0, yz = 0.0, zz = 1.0;

  void add(double along, const Vec3& e) noexcept {
    const Vec3 f = along * e;
    xx += f.x * e.x, xy += f.x * e.y, xz += f.x * e.z, yy += f.y * e.y, yz += f.y * e.z, zz += f.z * e.z;
  }
  void add(double along, const detail::Face& face) noexcept {
    for (int i = 0; i < face.size; ++i) add(along, face.q[i]);
  }
  void add_everywhere(double f) noexcept { xx += f, yy += f, zz += f; }
};

/// M = L D Lᵀ, for any number of right sides. Needs no pivoting: D ≥ 1 but for rounding.
class Factor {
 public:
  explicit Factor(const Stiffness& M) noexcept : by_dx_(1.0 / M.xx), lyx_(M.xy * by_dx_), lzx_(M.xz * by_dx_) {
    by_dy_ = 1.0 / std::max(1.0, M.yy - lyx_ * M.xy);
    const double yz = M.yz - lyx_ * M.xz;
    lzy_ = yz * by_dy_;
    by_dz_ = 1.0 / std::max(1.0, M.zz - lzx_ * M.xz - lzy_ * yz);
  }
  Vec3 solve(const Vec3& g) const noexcept {
    const double gy = g.y - lyx_ * g.x;
    const double z = (g.z - lzx_ * g.x - lzy_ * gy) * by_dz_;
    const double y = gy * by_dy_ - lzy_ * z;
    return {g.x * by_dx_ - lyx_ * y - lzx_ * z, y, z};
  }

 private:
  double by_dx_, lyx_, lzx_, by_dy_, lzy_, by_dz_;
};

// Force of a primitive that is pulled by w, within its span, through a spring of stiffness τ (1: the coupling itself): the u of
// ∂φ at R = (w − u)/τ. Equal to the demand up to s; beyond, s and the drag's share of the rest.
inline double length_given(double asked, double s, double gamma, double tau) noexcept {
  return gamma > 0.0 ? s + gamma * ((asked - s) / (tau + gamma)) : s;
}
inline Vec3 answer(const Span& p, const Vec3& w, double tau) noexcept {
  const double squared = norm_squared(w);
  if (squared <= p.s * p.s) return w;
  const double asked = std::sqrt(squared);
  return (length_given(asked, p.s, p.gamma, tau) / asked) * w;
}
inline double answer(const Plane& p, double w, double tau) noexcept {
  if (p.compliance > 0.0) w /= 1.0 + p.compliance * tau;
  return w <= p.s ? std::max(0.0, w) : length_given(w, p.s, p.gamma, tau);
}

}  // namespace detail::solving

/// Problem in newtons about an origin, the iterate (Z and all forces), and the best iterate so far.
class Solver::Work {
  using Corner = detail::Corner;
  using Plane = detail::Plane;
  using Span = detail::Span;
  using Stiffness = detail::solving::Stiffness;

 public:
  explicit Work(std::size_t capacity)
      : planes_(std::make_unique<Plane[]>(capacity)),
        spans_(std::make_unique<Span[]>(capacity)),
        corners_(std::make_unique<Corner[]>(capacity / 2)),
        normals_(std::make_unique<Vec3[]>(capacity)),
        offsets_n_(std::make_unique<double[]>(capacity)),
        kept_planes_n_(std::make_unique<double[]>(capacity)),
        kept_spans_n_(std::make_unique<Vec3[]>(capacity)),
        kept_corners_(std::make_unique<Corner[]>(capacity / 2)),
        best_forces_n_(std::make_unique<Vec3[]>(capacity)) {}

  /// Sets a problem and its initial forces, in the order of the set. \param k [N/m], \param T [s] of Solver::solve
  void pose(std::span<const Primitive> primitives, const Vec3* warm_n, const Vec3& start_m, const Vec3& probe_m, double k,
            double T) noexcept;
  void solve() noexcept;
  /// Writes the best balance and its forces, in the order of the set; stores the proxy's motion for the next warm start.
  void give(Balance& balance, Vec3& remainder_m, Vec3* forces_n) noexcept;

  /// Buffer for forces [N] in the order of the set, free until `solve`.
  Vec3* spare_forces() noexcept { return best_forces_n_.get(); }

 private:
  void anchor(Plane& plane) const noexcept;
  void anchor(Span& span) const noexcept;
  void anchor(const Corner& corner) noexcept;
  /// Sets all but the sides of a problem; returns its number of points.
  std::size_t begin(std::span<const Primitive> primitives, const Vec3& start_m, const Vec3& probe_m, double k) noexcept;
  void pose_corner(std::size_t first, std::size_t facets, const Vec3* warm_n) noexcept;
  void recentre() noexcept;
  Vec3 sum() const noexcept;
  bool certify(int stage) noexcept;

  bool solve_from_before() noexcept;
  bool round() noexcept;
  bool shows_in_gap(double off_n, double longest_n, double gamma) const noexcept;
  bool in_closed_form() noexcept;
  bool corner_in_closed_form() noexcept;
  void sweep() noexcept;
  void add_common_points() noexcept;

  enum class Step { settled, slow, cut };
  Step active_set_step() noexcept;
  struct Sides {
    Stiffness M;
    Vec3 g;
  };
  Sides take_sides() noexcept;
  void take_side(Corner& corner, Stiffness& M, Vec3& g) const noexcept;
  struct Moved {
    Vec3 left;  // residual force
    Vec3 held;  // remaining τR of the sticking primitives
  };
  Moved move(const Vec3& dZ) noexcept;
  bool confine() noexcept;

  void augmented_lagrangian() noexcept;
  bool minimise(double tau) noexcept;
  double search(const Vec3& d, double slope_at_start, double tau) const noexcept;
  double slope(const Vec3& at, const Vec3& d, double tau) const noexcept;
  void keep() noexcept;
  void restore() noexcept;

  Vec3 moved_m_;  // from the start to the previous balance

  // The problem.
  std::span<const Primitive> primitives_;
  Vec3 start_m_, probe_m_, directed_n_;
  double directed_size_n_ = 0.0, directed_terms_ = 0.0;
  double k_ = 1.0, by_k_ = 1.0;
  double wanted_n_ = 0.0;    // k times the target bound
  double balanced_n_ = 0.0;  // negligible residual force
  double shown_n2_ = 0.0;    // s times a rounding of B that would show in the bound

  // In newtons about the origin.
  Vec3 origin_m_, C_, Z_;
  double C_size_ = 0.0;
  std::unique_ptr<Plane[]> planes_;
  std::unique_ptr<Span[]> spans_;  // lines first, then points
  std::unique_ptr<Corner[]> corners_;
  std::unique_ptr<Vec3[]> normals_;      // of all corners' facets
  std::unique_ptr<double[]> offsets_n_;  // b of all corners' facets
  std::size_t plane_count_ = 0, line_count_ = 0, all_spans_ = 0, corner_count_ = 0, facet_count_ = 0;
  std::size_t span_count_ = 0;  // active now: all, or the lines alone while `common_`
  bool common_ = false;         // points with a common anchor: added in closed form
  bool warm_ = false;
  bool precise_ = false;             // double-double anchors from the next recentring on
  bool anchored_precisely_ = false;  // the present anchors are double-double

  std::unique_ptr<double[]> kept_planes_n_;
  std::unique_ptr<Vec3[]> kept_spans_n_;
  std::unique_ptr<Corner[]> kept_corners_;
  Vec3 kept_Z_;

  std::unique_ptr<Vec3[]> best_forces_n_;
  Vec3 best_origin_m_, best_Z_;
  double best_bound_n_ = 0.0;
  bool done_ = false;  // the best iterate is the last
  int best_stage_ = 0, iterations_ = 0;
};

}  // namespace palpa
