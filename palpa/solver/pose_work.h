// State of one balance of a tool, and the stages that find it (docs/theory.md 10). Internal to the solver.
//
// The unknown is Z = k (ξ, ρω) about an origin, six numbers in newtons. A foot with β = b/ρ moves by J Z = Z₁ + Z₂ × β, and its
// force u acts by Jᵀu = (u, β × u). With J Z in place of Z, primitives and gaps are those of newton_form.h.
#pragma once

#include <array>

#include "palpa/solver/pose_solver.h"
#include "palpa/solver/solver_work.h"

namespace palpa {

namespace detail::posing {

using detail::solving::Stiffness;

/// Vector of six: of a motion the way and the arc, of a wrench the force and the torque divided by ρ.
struct Six {
  Vec3 way, arc;
  Six& operator+=(const Six& b) noexcept { return way += b.way, arc += b.arc, *this; }
  Six& operator-=(const Six& b) noexcept { return way -= b.way, arc -= b.arc, *this; }
};
inline Six operator+(const Six& a, const Six& b) noexcept { return {a.way + b.way, a.arc + b.arc}; }
inline Six operator-(const Six& a, const Six& b) noexcept { return {a.way - b.way, a.arc - b.arc}; }
inline Six operator*(double f, const Six& a) noexcept { return {f * a.way, f * a.arc}; }
inline double dot(const Six& a, const Six& b) noexcept { return palpa::dot(a.way, b.way) + palpa::dot(a.arc, b.arc); }
inline double size_of(const Six& a) noexcept { return detail::size_of(a.way) + detail::size_of(a.arc); }
inline bool is_finite(const Six& a) noexcept { return palpa::is_finite(a.way) && palpa::is_finite(a.arc); }

/// J Z of a foot.
inline Vec3 at_foot(const Six& Z, const Vec3& beta) noexcept { return Z.way + cross(Z.arc, beta); }
/// Jᵀu of a force at a foot.
inline Six wrench(const Vec3& u, const Vec3& beta) noexcept { return {u, cross(beta, u)}; }

/// 6×6 matrix M = I + Σ Jᵀ K J, symmetric, M ≥ I, and its factors L D Lᵀ: no pivoting is needed, D ≥ 1 but for rounding.
class Factor6 {
 public:
  /// Adds a foot's stiffness.
  void add(const Stiffness& K, const Vec3& beta) noexcept;
  void factor() noexcept;
  Six solve(const Six& g) const noexcept;

 private:
  Stiffness way_, arc_;                       // diagonal blocks
  Vec3 rows_[3];                              // of the block arc × way
  std::array<std::array<double, 6>, 6> l_{};  // lower triangle
  std::array<double, 6> by_d_{};
};

/// A foot with primitives.
struct Foot {
  Vec3 beta;          // b/ρ
  Vec3 lever_m;       // b
  Vec3 start_m;       // in space
  double gain = 1.0;  // 1 + |β|²: the largest compliance of the coupling at the foot, times k
  double size = 0.0;  // of β
  Vec3 Z;             // J Z
  Vec3 u;             // sum of its forces
  Stiffness K = none;
  bool is_stiff = false;  // K is not zero
  static constexpr Stiffness none{0.0, 0.0, 0.0, 0.0, 0.0, 0.0};

  void stiffen(double along, const Vec3& e) noexcept { K.add(along, e), is_stiff = true; }
};

}  // namespace detail::posing

/// Problem in newtons about an origin, the iterate (Z and all forces), and the best iterate so far.
class PoseSolver::Work {
  using Corner = detail::Corner;
  using Foot = detail::posing::Foot;
  using Plane = detail::Plane;
  using Six = detail::posing::Six;
  using Span = detail::Span;

 public:
  Work(std::size_t capacity, std::size_t feet);

  /// Sets a problem and its initial forces, in the order of the set. `whole`: no plane is left out of the working set.
  void pose(std::span<const Primitive> primitives, const Vec3* warm_n, const ToolStep& step, bool whole) noexcept;
  void solve() noexcept;
  /// Writes the best balance and its forces, in the order of the set.
  void give(Balance& balance, Vec3* forces_n) noexcept;
  /// Bound [m] of the motion `at` from the start [m] with the posed forces.
  double bound_m(const Motion& at) noexcept;

  /// Buffer for forces [N] in the order of the set, free until `solve`.
  Vec3* spare_forces() noexcept { return best_forces_n_.get(); }

 private:
  /// Primitive of a kind, and its foot.
  template <class Kind>
  struct AtFoot : Kind {
    std::uint16_t foot = 0;  // in feet_
    double gain = 1.0;       // compliance of the coupling along it, times k
  };
  /// Line or point at a foot, and of one that slips the side that it was taken to be on.
  struct FootSpan : AtFoot<Span> {
    Vec3 e, at;                     // direction of its force, and its R there
    double stiffness_across = 0.0;  // of the force across e
  };
  /// Pull of a primitive along a step of Newton's method: start + share · change.
  struct PlaneRay {
    double start = 0.0, change = 0.0;  // divided by `yields`
    double s = 0.0, drag = 0.0;        // drag: its share of what is beyond s
    double yields = 1.0;               // 1 + cτ
  };
  struct SpanRay {
    Vec3 start, change;
    double s = 0.0, drag = 0.0;
  };
  struct Sides {
    Six g;
    detail::posing::Factor6 M;
  };
  struct Moved {
    Six left;             // residual wrench
    Six held;             // remaining τR of the sticking primitives
    bool turned = false;  // a slip: its side is to be taken again
  };
  enum class Step { settled, slow, cut };

  std::uint16_t foot_of(const Primitive& primitive, const ToolStep& step) noexcept;
  void pose_plane(std::size_t i, double t) noexcept;
  void pose_span(std::size_t i, const Vec3& warm_n) noexcept;
  void pose_corner(std::size_t first, std::size_t facets, const Vec3* warm_n) noexcept;
  bool is_at_origin(const Primitive& primitive, const Foot& foot) const noexcept;
  void anchor(AtFoot<Plane>& plane) const noexcept;
  void anchor(FootSpan& span) const noexcept;
  void anchor(const AtFoot<Corner>& corner) noexcept;
  void anchor_all() noexcept;
  void recentre() noexcept;
  bool is_recentring_shown() const noexcept;
  void look() noexcept;
  Six sum() noexcept;
  Six gathered() noexcept;
  /// Terms of a bound, and the bound without rounding.
  struct Proven {
    double bound_n = 0.0, plain_n = 0.0, left_n = 0.0, rounding_n = 0.0;
    double all_left_n = 0.0, gap_n2 = 0.0, share = 1.0;
  };
  Proven prove() noexcept;
  static double bound_of(double left_n, double gap_n2) noexcept;
  bool certify(int stage) noexcept;
  bool any_left() const noexcept { return rows_ < most_rows; }
  std::size_t size() const noexcept { return planes_ + spans_ + corners_; }
  void count() noexcept { ++iterations_, rows_ += 4 * static_cast<int>(size()); }

  bool solve_set() noexcept;
  double depth_n(const Primitive& plane) const noexcept;
  bool widen() noexcept;
  void take_in(std::size_t place) noexcept;
  void sweep() noexcept;
  bool advance() noexcept;
  bool round() noexcept;
  Step active_set_step() noexcept;
  Sides take_sides() noexcept;
  void take_side(AtFoot<Corner>& corner, Foot& foot) const noexcept;
  Moved move(const Six& dZ) noexcept;
  static bool slip(FootSpan& span, const Vec3& R) noexcept;
  bool confine() noexcept;
  bool augmented_lagrangian() noexcept;
  bool minimise(double tau) noexcept;
  double pull(double tau) noexcept;
  double pull_corners(double tau) noexcept;
  double search(const Six& d, double slope_at_start, double tau) noexcept;
  void cast(const Six& d, double tau) noexcept;
  double slope(double share, const Six& d, double tau) noexcept;
  void answer_all(double tau) noexcept;
  void keep() noexcept;
  void restore() noexcept;

  // [1] Rows that all passes of a balance may visit, at about 3 ns each; most passes visit a row as long as four. More: longer
  // worst case; fewer: more balances are `capped`.
  static constexpr int most_rows = 450000;

  // The problem.
  std::span<const Primitive> primitives_;
  ToolStep step_;
  Six way_n_, directed_n_;
  double directed_size_n_ = 0.0, directed_terms_ = 0.0;
  double k_ = 1.0, by_k_ = 1.0;
  double wanted_n_ = 0.0;     // k times the target bound
  double balanced_n_ = 0.0;   // negligible residual force
  double strongest_n_ = 0.0;  // of the working set
  double shown_n2_ = 0.0;     // s times a rounding of B that would show in the bound

  // In newtons about the origin.
  Six origin_m_, C_, Z_;
  double C_size_ = 0.0;
  std::unique_ptr<std::uint16_t[]> numbers_;  // by the tool's foot: its place in feet_
  std::unique_ptr<Foot[]> feet_;              // with primitives
  std::unique_ptr<AtFoot<Plane>[]> plane_;
  std::unique_ptr<FootSpan[]> span_;
  std::unique_ptr<AtFoot<Corner>[]> corner_;
  std::unique_ptr<Vec3[]> normals_;      // of all corners' facets
  std::unique_ptr<double[]> offsets_n_;  // b of all corners' facets
  std::size_t all_feet_, feet_count_ = 0, planes_ = 0, spans_ = 0, corners_ = 0, facets_ = 0;
  bool warm_ = false;
  bool precise_ = false;             // double-double anchors from the next recentring on
  bool anchored_precisely_ = false;  // the present anchors are double-double

  // Planes outside the working set: their places in the set. They pressed on nothing at the last balance.
  std::unique_ptr<std::uint32_t[]> rest_;
  std::size_t rest_count_ = 0;

  std::unique_ptr<PlaneRay[]> plane_rays_;
  std::unique_ptr<SpanRay[]> span_rays_;
  std::unique_ptr<double[]> kept_planes_n_;
  std::unique_ptr<Vec3[]> kept_spans_n_;
  std::unique_ptr<Corner[]> kept_corners_;
  Six kept_Z_;

  std::unique_ptr<Vec3[]> best_forces_n_;
  Six best_m_;
  Six best_rest_n_;
  double best_left_n_ = 0.0, best_gap_n2_ = 0.0, best_share_ = 1.0;  // terms of the best bound
  double best_bound_n_ = 0.0, bound_n_ = 0.0;                        // of the best and of the last iterate
  int best_stage_ = 0, iterations_ = 0, rows_ = 0;
};

}  // namespace palpa
