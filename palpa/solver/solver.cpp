#include "palpa/solver/solver.h"

#include <cassert>
#include <limits>

#include "palpa/solver/double2.h"
#include "palpa/solver/newton_form.h"

namespace palpa {

using detail::Corner;
using detail::epsilon;
using detail::gap;
using detail::Plane;
using detail::Proof;
using detail::size_of;
using detail::Span;
using detail::State;

namespace {

// [m] Target bound, tighter than `exact_bound_m`. Larger: nearly parallel lines stay a little above the claim; smaller: more
// rounds, in the end for rounding.
constexpr double wanted_bound_m = 2e-10;

// [1] Residual force at which refining ends, as a share of k times the target bound. Less: more refinements; more: it nears
// `seen_share`.
constexpr double refined_share = 8e-6;
// [1] Residual force in a result, likewise. Less: more rounds; more: visible in a sum of the forces.
constexpr double seen_share = 1e-3;
// [1] Bound, in target bounds, below which common points join the balance. Less: the rounding of their closed form is kept
// longer; more: the closed form is dropped sooner.
constexpr double near_share = 100.0;

// [1] In squared target bounds: rounding that a closed form may leave in the duality gap. Less: the stages run where a sweep
// would do; more: visible in a check by the gap, which takes its root.
constexpr double shown_by_root = 9.0;

// [1] Caps. More: a longer worst case; fewer: more balances end with a later stage, or as `capped`. Nearly all balances need
// one round; the multipliers converge within five penalties, later only the bound is slow.
constexpr int max_rounds = 10;
constexpr int max_rounds_in_vain = 2;      // rounds that do not halve the bound, before the multipliers
constexpr std::size_t many = 12;           // primitives: above this, a single such round is enough
constexpr int max_steps_in_a_round = 3;    // of the active set, before a proof
constexpr int max_rounds_from_before = 2;  // warm start
constexpr int max_refinements = 8;         // of one active-set step, with constant M
constexpr int max_penalties = 20;
constexpr int max_newton_steps = 30;  // at one penalty
constexpr int max_search_steps = 60;  // along one Newton step

// [1] A refinement that leaves more of the force than this share is slow: M is rebuilt. Less: more factorisations; more: more
// refinements.
constexpr double slow_share = 0.05;

// [1] τ of the active set: the spring that demands R = 0 of a sticking primitive. Softer: more refinements; stiffer: M loses
// digits. An elastic primitive demands R = cu instead: its spring is τ/(1 + cτ), and 1/(1 + cτ) of its demand is left after a
// move.
constexpr double spring = 1e8;
double rest_of_spring(double compliance) noexcept { return compliance > 0.0 ? 1.0 / (1.0 + compliance * spring) : 1.0; }

// [1] First penalty; each is ten times its predecessor. Lower: more penalties; higher: Newton's method may fail from afar.
constexpr double first_penalty = 1e3;
// [1] Up to this penalty a failed Newton method restarts with a hundredth of it, above with its result. Lower: poor minima are
// used; higher: more penalties.
constexpr double unsteady_penalty = 1e6;
// [1] From this penalty on the states are clear enough for the active set. Lower: it tries in vain; higher: the last digits
// cost more penalties.
constexpr double steady_penalty = 1e8;
// [1] Higher: M loses digits; lower: the last digits are not reached.
constexpr double largest_penalty = 1e14;

// Accepted k, far beyond any device: with the limits of PrimitiveSet nothing overflows; outside: `bad_input`.
constexpr double softest_n_per_m = 1e-12;
constexpr double stiffest_n_per_m = 1e12;

bool usable(const Vec3& position_m) noexcept {
  return is_finite(position_m) && largest_component(position_m) <= largest_position_m;
}

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
double length_given(double asked, double s, double gamma, double tau) noexcept {
  return gamma > 0.0 ? s + gamma * ((asked - s) / (tau + gamma)) : s;
}
Vec3 answer(const Span& p, const Vec3& w, double tau) noexcept {
  const double squared = norm_squared(w);
  if (squared <= p.s * p.s) return w;
  const double asked = std::sqrt(squared);
  return (length_given(asked, p.s, p.gamma, tau) / asked) * w;
}
double answer(const Plane& p, double w, double tau) noexcept {
  if (p.compliance > 0.0) w /= 1.0 + p.compliance * tau;
  return w <= p.s ? std::max(0.0, w) : length_given(w, p.s, p.gamma, tau);
}

}  // namespace

/// Problem in newtons about an origin, the iterate (Z and all forces), and the best iterate so far.
class Solver::Work {
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

  /// Sets a problem and its initial forces, in the order of the set.
  void pose(std::span<const Primitive> primitives, const Vec3* warm_n, const Vec3& start_m, const Vec3& probe_m, double k,
            double T) noexcept;
  void solve() noexcept;
  /// Writes the best balance and its forces, in the order of the set; stores the proxy's motion for the next warm start.
  void give(Balance& balance, Vec3& remainder_m, Vec3* forces_n) noexcept;

  /// Buffer for forces in the order of the set, free until `solve`.
  Vec3* spare_forces() noexcept { return best_forces_n_.get(); }

 private:
  void anchor(Plane& plane) const noexcept;
  void anchor(Span& span) const noexcept;
  void anchor(const Corner& corner) noexcept;
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

void Solver::Work::pose(std::span<const Primitive> primitives, const Vec3* warm_n, const Vec3& start_m, const Vec3& probe_m,
                        double k, double T) noexcept {
  primitives_ = primitives;
  start_m_ = start_m, probe_m_ = probe_m;
  k_ = k, by_k_ = 1.0 / k;
  wanted_n_ = k * wanted_bound_m;
  balanced_n_ = refined_share * wanted_n_;
  // [1] Rounding of an anchor counts by its root: a tenth may cost √0.1 of the target bound. Less: more double-double anchors,
  // which are slower; more: rounding of anchors spoils bounds.
  shown_n2_ = 0.1 * wanted_n_ * wanted_n_;
  precise_ = anchored_precisely_ = false;
  best_bound_n_ = std::numeric_limits<double>::max();
  best_origin_m_ = start_m, best_Z_ = {};
  done_ = false;
  iterations_ = 0;

  directed_n_ = {};
  directed_size_n_ = directed_terms_ = 0.0;
  std::size_t points = 0;
  line_count_ = 0;
  for (const Primitive& p : primitives) {
    points += p.kind == PrimitiveKind::point, line_count_ += p.kind == PrimitiveKind::line;
    if (p.kind != PrimitiveKind::directed) continue;
    directed_n_ += p.strength_n * p.direction;
    directed_size_n_ += 2.0 * p.strength_n;
    directed_terms_ += 1.0;
  }
  all_spans_ = line_count_ + points;

  // About the start: primitives placed there, as modes do, get B = 0 exactly.
  origin_m_ = start_m;
  const Vec3 way_n = k * (probe_m - start_m);
  C_ = way_n + directed_n_;
  C_size_ = 2.0 * size_of(way_n) + directed_size_n_;
  plane_count_ = corner_count_ = facet_count_ = 0;
  std::size_t line = 0, point = line_count_;
  const Vec3* first_m = nullptr;
  common_ = points > 0;
  warm_ = false;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    const double gamma = detail::gamma_of(p, k, T);
    if (!first_m) first_m = &p.position_m;
    common_ = common_ && p.position_m == *first_m && (gamma == 0.0 || p.kind == PrimitiveKind::point) && !p.is_elastic();
    const double longest = gamma > 0.0 ? std::numeric_limits<double>::infinity() : p.strength_n;
    if (p.kind == PrimitiveKind::corner) {
      const std::span<const Primitive> facets = whole_of(primitives, i);
      for (const Primitive& facet : facets) common_ = common_ && facet.position_m == *first_m;
      if (facets.size() > 1) {
        pose_corner(i, facets.size(), warm_n);
        i += facets.size() - 1;
        continue;
      }
    }
    if (p.kind == PrimitiveKind::plane || p.kind == PrimitiveKind::corner) {
      Plane& plane = planes_[plane_count_++];
      plane.q = p.direction, plane.s = p.strength_n, plane.gamma = gamma, plane.index = static_cast<std::uint32_t>(i);
      plane.compliance = detail::compliance_of(p, k);
      plane.rest = rest_of_spring(plane.compliance);
      plane.t = std::clamp(dot(p.direction, warm_n[i]), 0.0, longest);
      warm_ = warm_ || plane.t > 0.0;
      anchor(plane);
    } else {
      Span& span = spans_[p.kind == PrimitiveKind::line ? line++ : point++];
      span.q = p.direction, span.s = p.strength_n, span.gamma = gamma, span.index = static_cast<std::uint32_t>(i);
      span.u = span.across(warm_n[i]);
      if (norm_squared(span.u) > longest * longest) span.u = shortened(span.u, longest);
      warm_ = warm_ || span.u != Vec3{};
      anchor(span);
    }
  }
  common_ = common_ && plane_count_ + line_count_ + corner_count_ > 0;
  span_count_ = common_ ? line_count_ : all_spans_;
}

void Solver::Work::pose_corner(std::size_t first, std::size_t facets, const Vec3* warm_n) noexcept {
  Corner& corner = corners_[corner_count_++];
  corner.normals = {&normals_[facet_count_], facets};
  corner.b = &offsets_n_[facet_count_];
  corner.s = primitives_[first].strength_n;
  corner.compliance = detail::compliance_of(primitives_[first], k_);
  corner.rest = rest_of_spring(corner.compliance);
  corner.index = static_cast<std::uint32_t>(first);
  corner.face.size = 0;
  corner.u = {};
  for (std::size_t i = first; i < first + facets; ++i) {
    normals_[facet_count_++] = primitives_[i].direction;
    corner.u += std::max(0.0, dot(primitives_[i].direction, warm_n[i])) * primitives_[i].direction;
  }
  corner.u = shortened(corner.u, corner.s);
  warm_ = warm_ || corner.u != Vec3{};
  anchor(corner);
}

// Anchors relative to the origin. Rounding of B shifts the anchor: where the proxy rests with strength s it costs √(s|shift|)
// in the bound, so where that would show, the difference and its component along q are computed in double-double.
void Solver::Work::anchor(Plane& p) const noexcept {
  const Vec3& a = primitives_[p.index].position_m;
  if (a == origin_m_) {
    p.b = p.size = 0.0;
    return;
  }
  const Vec3 B = k_ * (a - origin_m_);
  p.b = dot(p.q, B);
  p.size = size_of(B);
  if (precise_ || p.s * p.size * epsilon > shown_n2_) {
    p.b = k_ * detail::slide(p.q, a, origin_m_).along;
    p.size = std::abs(p.b);
  }
}

void Solver::Work::anchor(Span& p) const noexcept {
  const Primitive& primitive = primitives_[p.index];
  if (primitive.position_m == origin_m_) {
    p.B = {}, p.size = 0.0;
    return;
  }
  p.B = k_ * (primitive.position_m - origin_m_);
  p.size = size_of(p.B);
  if (primitive.kind == PrimitiveKind::point) return;
  if (precise_ || p.s * p.size * epsilon > shown_n2_) {
    p.B = k_ * detail::slide(p.q, primitive.position_m, origin_m_).across;
    p.size = size_of(p.B);
  } else {
    p.B = p.across(p.B);
  }
}

// A shift of a facet shifts its edges, by the inverse of their angle: always double-double.
void Solver::Work::anchor(const Corner& corner) noexcept {
  double* const b = &offsets_n_[static_cast<std::size_t>(corner.b - offsets_n_.get())];
  for (std::size_t i = 0; i < corner.normals.size(); ++i) {
    b[i] = k_ * detail::slide(corner.normals[i], primitives_[corner.index + i].position_m, origin_m_).along;
  }
}

// Moves the origin to the proxy. Residuals of primitives that the proxy rests on are then differences of nearby doubles: exact
// where rounding would be multiplied by τ or stand under a root.
void Solver::Work::recentre() noexcept {
  const Vec3 z_m = by_k_ * Z_;
  const Vec3 origin_m = origin_m_ + z_m;
  Z_ = k_ * ((origin_m_ - origin_m) + z_m);
  origin_m_ = origin_m;
  const Vec3 way_n = k_ * (probe_m_ - origin_m);
  C_ = way_n + directed_n_;
  C_size_ = 2.0 * size_of(way_n) + directed_size_n_;
  anchored_precisely_ = precise_;
  for (std::size_t i = 0; i < plane_count_; ++i) anchor(planes_[i]);
  for (std::size_t i = 0; i < all_spans_; ++i) anchor(spans_[i]);
  for (std::size_t i = 0; i < corner_count_; ++i) anchor(corners_[i]);
}

// Z at which these forces balance.
Vec3 Solver::Work::sum() const noexcept {
  Vec3 sum = C_;
  for (std::size_t i = 0; i < plane_count_; ++i) sum += planes_[i].t * planes_[i].q;
  for (std::size_t i = 0; i < span_count_; ++i) sum += spans_[i].u;
  for (std::size_t i = 0; i < corner_count_; ++i) sum += corners_[i].u;
  return sum;
}

// Whether the iterate is good enough; stores it if its bound is the best so far.
bool Solver::Work::certify(int stage) noexcept {
  const Vec3 rest = Z_;
  if (common_) add_common_points();

  Proof proof(Z_, C_, C_size_, directed_terms_ + 1.0);
  const double size_of_Z = size_of(Z_);
  for (std::size_t i = 0; i < plane_count_; ++i) proof.add(gap(planes_[i], Z_, size_of_Z), planes_[i].t * planes_[i].q);
  for (std::size_t i = 0; i < span_count_; ++i) proof.add(gap(spans_[i], Z_), spans_[i].u);
  for (std::size_t i = 0; i < corner_count_; ++i) proof.add(gap(corners_[i], Z_), corners_[i].u);
  ++iterations_;

  const double bound_n = proof.bound();
  const double plain_n = proof.plain_bound();
  bool proven = bound_n <= wanted_n_;
  if (!proven && plain_n <= 0.5 * wanted_n_) {
    // Without rounding the bound would be small enough, with room: anchors are double-double from here on. Four times the
    // target bound is accepted, which still is below `exact_bound_m` (more: `exact` would be a false claim; less: more rounds
    // for rounding alone), and any bound if the precision is exhausted. Half: more blames rounding wrongly; less uses
    // double-double late.
    proven = bound_n <= 4.0 * wanted_n_ || anchored_precisely_;
    precise_ = true;
  }
  // A residual force costs little in the bound, but is visible in a sum of the forces.
  const bool done = proven && proof.left() <= seen_share * wanted_n_ + proof.rounding();

  done_ = done;
  if (done || bound_n < best_bound_n_) {
    best_bound_n_ = bound_n;
    best_origin_m_ = origin_m_, best_Z_ = Z_;
    best_stage_ = stage;
    if (!done) {
      for (std::size_t i = 0; i < plane_count_; ++i) best_forces_n_[planes_[i].index] = planes_[i].t * planes_[i].q;
      for (std::size_t i = 0; i < span_count_; ++i) best_forces_n_[spans_[i].index] = spans_[i].u;
      for (std::size_t i = 0; i < corner_count_; ++i) corners_[i].give(best_forces_n_.get());
    }
  }
  if (common_ && !done) {
    // This near, rounding matters: it is least with the origin at the balance of all, not at that without the points.
    common_ = plain_n > near_share * wanted_n_;
    if (common_) span_count_ = line_count_, Z_ = rest;
  }
  return done;
}

// 1. Sweeps: block coordinate descent of the dual. With all forces but u held, Z without it is Z − u, and u is the response to
// the pull P(B − (Z − u)) = R + u of the coupling itself.
void Solver::Work::sweep() noexcept {
  Vec3 Z = Z_;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    const double t = answer(p, p.residual(Z) + p.t, 1.0);
    Z += (t - p.t) * p.q;
    p.t = t;
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    const Vec3 u = answer(p, p.across(p.B - Z + p.u), 1.0);
    Z += u - p.u;
    p.u = u;
  }
  for (std::size_t i = 0; i < corner_count_; ++i) {
    Corner& p = corners_[i];
    const Vec3 before = p.u;
    p.answer(p.pull(Z, 1.0), 1.0);
    Z += p.u - before;
  }
  Z_ = Z;
}

// Points with a common anchor, the others without drag: φ of the points together is a function of |R| alone, and that of the
// others is homogeneous, so the balance is that of the others, drawn towards the anchor as by one point with the strength and
// drag of all. The proxy stays on the primitives that it rested on.
void Solver::Work::add_common_points() noexcept {
  double s = 0.0, gamma = 0.0;
  for (std::size_t i = line_count_; i < all_spans_; ++i) s += spans_[i].s, gamma += spans_[i].gamma;
  const Vec3& B = spans_[line_count_].B;
  const Vec3 w = B - Z_;
  const double asked = std::sqrt(norm_squared(w));
  span_count_ = all_spans_;
  if (asked > s) {
    const double beyond = (asked - s) / (1.0 + gamma);
    const Vec3 e = (1.0 / asked) * w;
    for (std::size_t i = line_count_; i < all_spans_; ++i) spans_[i].u = (spans_[i].s + spans_[i].gamma * beyond) * e;
    if (s > 0.0 || gamma > 0.0) Z_ = B - beyond * e;
  } else {
    for (std::size_t i = line_count_; i < all_spans_; ++i) spans_[i].u = s > 0.0 ? (spans_[i].s / s) * w : Vec3{};
    Z_ = B;
  }
}

// 2. Active set. With w = R + u the pull as in a sweep, a primitive sticks where |w| ≤ s; there R = 0 is demanded, by a spring
// of stiffness τ that starts from u. Where it slips, its force is s + γ|R| along e = w/|w|, and for a move dZ it changes by −γ
// along e and by −K across it, K = |u|/(|w| − |u|) with the |u| in response to w. Together this is a linear system for dZ:
//     M dZ = C + Σ(force at dZ = 0) − Z,   M = I + ΣK.
// The spring leaves R = (u⁺ − u)/τ, and the turn of the slipping forces leaves a force. Solving again with this M, for that
// force and that R (not as a difference of large numbers), reduces both to rounding. Where that converges slowly M is rebuilt,
// and where a force had to be cut to its admissible set, a sweep renews the states.
Solver::Work::Step Solver::Work::active_set_step() noexcept {
  const Sides sides = take_sides();
  const Factor factor(sides.M);
  Vec3 g = sides.g;
  bool slow = false;
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < max_refinements && !slow; ++i) {
    const Moved moved = move(factor.solve(g));
    const double size = size_of(moved.left);
    // Also ends when the residual force no longer halves: it is rounding, or it grows. More: useless refinements; less: slow
    // but useful ones are dropped.
    if ((i > 0 && size <= balanced_n_) || !(size < 0.5 * before)) break;
    slow = i > 0 && size > slow_share * before;
    before = size;
    g = moved.left + moved.held;
  }
  if (confine()) return Step::cut;
  return slow ? Step::slow : Step::settled;
}

// States of the primitives, and the resulting system: M, and its right side. Sticking primitives keep τR.
Solver::Work::Sides Solver::Work::take_sides() noexcept {
  const Vec3 Z = Z_;
  Stiffness M;
  Vec3 g = C_ - Z;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    const double r = p.residual(Z);
    const double w = r + p.t;
    if (w <= 0.0) {
      p.state = State::off, p.t = 0.0;
    } else if (w <= p.s * (1.0 + p.compliance)) {
      const double stiffness = spring * p.rest;
      p.state = State::stick, p.r = stiffness * (r - p.compliance * p.t);
      g += (p.t + p.r) * p.q;
      M.add(stiffness, p.q);
    } else {
      p.state = State::slip, p.r = r;
      g += (p.s + p.gamma * r) * p.q;
      M.add(p.gamma, p.q);
    }
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    const Vec3 R = p.residual(Z);
    const Vec3 w = R + p.u;
    const double squared = norm_squared(w);
    double across = spring;
    if (squared <= p.s * p.s) {
      p.state = State::stick, p.R = spring * R;
      g += p.u + p.R;
    } else {
      p.state = State::slip, p.R = R;
      const double asked = std::sqrt(squared);
      const double given = length_given(asked, p.s, p.gamma, 1.0);
      const Vec3 e = (1.0 / asked) * w;
      across = std::min(spring, given * ((1.0 + p.gamma) / (asked - p.s)));
      const double along = dot(e, R);
      g += (p.s + p.gamma * along - across * along) * e + across * R;
      M.add(p.gamma - across, e);
    }
    M.add_everywhere(across);
    M.add(-across, p.q);
  }
  for (std::size_t i = 0; i < corner_count_; ++i) take_side(corners_[i], M, g);
  return {M, g};
}

// A corner acts within the span of the face found by a sweep: its R is the vector to that face's hull.
void Solver::Work::take_side(Corner& p, Stiffness& M, Vec3& g) const noexcept {
  const detail::CornerFoot foot = p.pull(Z_, 1.0);
  double r[most_facets];
  for (std::size_t i = 0; i < p.normals.size(); ++i) r[i] = p.residual(i, Z_);
  p.face = foot.face;
  p.u = p.face.across(p.u);
  const Vec3 R = p.face.hull(r);
  const double squared = norm_squared(foot.w);
  if (p.face.size == 0) {
    p.state = State::off;
  } else if (std::sqrt(squared) <= p.s * (1.0 + p.compliance)) {
    const double stiffness = spring * p.rest;
    p.state = State::stick, p.R = stiffness * (R - p.compliance * p.u);
    g += p.u + p.R;
    M.add(stiffness, p.face);
  } else {
    p.state = State::slip, p.R = R;
    const double asked = std::sqrt(squared);
    const Vec3 e = (1.0 / asked) * foot.w;
    const double across = std::min(spring, p.s / (asked - p.s));
    g += (p.s - across * dot(e, R)) * e + across * R;
    M.add(across, p.face);
    M.add(-across, e);
  }
}

// Moves Z by dZ, and every force with its state.
Solver::Work::Moved Solver::Work::move(const Vec3& dZ) noexcept {
  Z_ += dZ;
  Vec3 left = C_ - Z_, held;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    if (p.state == State::off) continue;
    if (p.state == State::stick) {
      p.r -= spring * p.rest * dot(p.q, dZ);
      p.t += p.r;
      p.r *= p.rest;
      held += p.r * p.q;
    } else {
      p.r -= dot(p.q, dZ);
      p.t = p.s + p.gamma * std::max(0.0, p.r);
    }
    left += p.t * p.q;
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    if (p.state == State::stick) {
      p.R = p.across(p.R - spring * dZ);
      p.u += p.R;
      held += p.R;
    } else {
      const Vec3 R = p.R - p.across(dZ);
      const double reach = std::sqrt(norm_squared(R));
      if (reach > 0.0 && dot(p.R + p.u, R) > 0.0) {  // else it would pass its anchor: it keeps its force
        p.u = ((p.s + p.gamma * reach) / reach) * R;
      }
      p.R = R;
    }
    left += p.u;
  }
  for (std::size_t i = 0; i < corner_count_; ++i) {
    Corner& p = corners_[i];
    if (p.state == State::stick) {
      p.R = p.face.across(p.R - spring * p.rest * dZ);
      p.u += p.R;
      p.R *= p.rest;
      held += p.R;
    } else if (p.state == State::slip) {
      const Vec3 R = p.R - p.face.across(dZ);
      const double reach = std::sqrt(norm_squared(R));
      if (reach > 0.0 && dot(p.R + p.u, R) > 0.0) p.u = (p.s / reach) * R;
      p.R = R;
    }
    left += p.u;
  }
  return {left, held};
}

// Projects the forces on their admissible sets: of primitives wrongly assumed to stick, and of rounding along a line. Returns
// whether any was cut by more than rounding.
bool Solver::Work::confine() noexcept {
  bool cut = false;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    if (p.state != State::stick) continue;
    const double t = std::clamp(p.t, 0.0, p.s);
    cut = cut || std::abs(t - p.t) > balanced_n_;
    p.t = t;
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    p.u = p.across(p.u);
    if (p.state != State::stick) continue;
    const double squared = norm_squared(p.u);
    if (squared > p.s * p.s) {
      const double length = std::sqrt(squared);
      cut = cut || length - p.s > balanced_n_;
      p.u *= p.s / length;
    }
  }
  for (std::size_t i = 0; i < corner_count_; ++i) {
    const Vec3 before = corners_[i].u;
    corners_[i].confine(corners_[i].state == State::slip);
    cut = cut || size_of(corners_[i].u - before) > balanced_n_;
  }
  return cut;
}

// 3. Method of multipliers. For a penalty τ the convex, once differentiable
//     Ψ(Z) = ½|Z − C|² + Σ max_v [v·R − φ*(v) − |v − u|²/(2τ)],   ∇Ψ = Z − C − Σ answer(u + τR)
// is minimised; the forces `answer` there are the next u. From any forces this converges to balanced forces, the faster the
// greater τ. Once the states are clear, an active-set step yields the last digits sooner.
void Solver::Work::augmented_lagrangian() noexcept {
  // Failed steps can leave forces far beyond s where a drag is large: no good start.
  bool too_long = false;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    if (!(p.t > p.s)) continue;
    p.t = p.s, too_long = true;
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    if (p.gamma == 0.0 || !(norm_squared(p.u) > p.s * p.s)) continue;
    p.u = shortened(p.u, p.s), too_long = true;
  }
  if (too_long) Z_ = sum();
  double tau = first_penalty;
  for (int i = 0; i < max_penalties; ++i) {
    recentre();
    if (!minimise(tau) && tau <= unsteady_penalty) {
      tau = std::max(1.0, 1e-2 * tau);
      continue;
    }
    for (std::size_t j = 0; j < plane_count_; ++j) {
      Plane& p = planes_[j];
      p.t = answer(p, p.t + tau * p.residual(Z_), tau);
    }
    for (std::size_t j = 0; j < span_count_; ++j) {
      Span& p = spans_[j];
      p.u = p.across(answer(p, p.u + tau * p.residual(Z_), tau));
    }
    for (std::size_t j = 0; j < corner_count_; ++j) corners_[j].answer(corners_[j].pull(Z_, tau), tau);
    if (certify(3)) return;
    if (i == 0 || tau > steady_penalty) {
      recentre();
      keep();
      active_set_step();
      if (certify(3)) return;
      restore();
    }
    tau = std::min(largest_penalty, 10.0 * tau);
  }
}

// Newton's method for Ψ, to the precision that the forces of this τ need. Returns whether it converged.
bool Solver::Work::minimise(double tau) noexcept {
  for (int step = 0; step < max_newton_steps; ++step) {
    Stiffness M;
    Vec3 g = C_ - Z_;  // −∇Ψ
    double size = size_of(C_);
    for (std::size_t i = 0; i < plane_count_; ++i) {
      const Plane& p = planes_[i];
      const double w = p.t + tau * p.residual(Z_);
      const double t = answer(p, w, tau);
      g += t * p.q;
      size += t;
      const double yields = 1.0 + p.compliance * tau;
      if (w > 0.0) M.add(w <= p.s * yields ? tau / yields : tau * (p.gamma / (tau + p.gamma)), p.q);
    }
    for (std::size_t i = 0; i < span_count_; ++i) {
      const Span& p = spans_[i];
      const Vec3 w = p.u + tau * p.residual(Z_);
      const double squared = norm_squared(w);
      double across = tau;
      if (squared <= p.s * p.s) {
        g += w;
      } else {
        const double asked = std::sqrt(squared);
        const double share = length_given(asked, p.s, p.gamma, tau) / asked;
        g += share * w;
        across = tau * share;
        M.add(tau * (p.gamma / (tau + p.gamma)) - across, (1.0 / asked) * w);
      }
      size += size_of(p.u);
      M.add_everywhere(across);
      M.add(-across, p.q);
    }
    for (std::size_t i = 0; i < corner_count_; ++i) {
      const Corner& p = corners_[i];
      const detail::CornerFoot foot = p.pull(Z_, tau);
      const double squared = norm_squared(foot.w);
      const double yields = 1.0 + p.compliance * tau;
      const bool slips = std::sqrt(squared) > p.s * yields;
      const double share = slips ? p.s / std::sqrt(squared) : 1.0 / yields;
      g += share * foot.w;
      size += size_of(p.u);
      M.add(tau * share, foot.face);
      if (slips) M.add(-tau * share, (1.0 / std::sqrt(squared)) * foot.w);
    }
    ++iterations_;
    // Up to a share of all forces that falls with τ, but not below rounding. Less: steps whose gain the next penalty replaces;
    // more: the next forces are worse, and more penalties are needed.
    if (size_of(g) <= std::max(4.0 * epsilon, 1e-6 / tau) * size) return true;
    const Vec3 d = Factor(M).solve(g);
    const double slope_at_start = -dot(g, d);
    if (!(slope_at_start < 0.0) || !is_finite(d)) return true;
    const double share = search(d, slope_at_start, tau);
    if (!(share > 0.0)) return true;
    Z_ += share * d;
  }
  return false;
}

// Step length along d, where Ψ is convex: its slope, negative at 0, only grows. The full step if that is not past the minimum;
// otherwise the minimum is bracketed, and a share is taken at which Ψ has surely fallen: before the minimum with half the slope
// gone, or past it by less than was gained before. 0 if rounding leaves no gain.
double Solver::Work::search(const Vec3& d, double slope_at_start, double tau) const noexcept {
  double low = 0.0, at_low = slope_at_start;
  double high = 1.0, at_high = slope(Z_ + d, d, tau);
  if (at_high <= 0.0) return high;
  for (int i = 0; i < max_search_steps; ++i) {
    const double secant = low + (high - low) * (at_low / (at_low - at_high));
    // The secant, at least a tenth from `low` and four tenths from `high`, so that it cannot creep where the slope has kinks.
    // Narrower limits: slower where Ψ is smooth; wider: it may creep.
    const double share = std::clamp(secant, low + 0.1 * (high - low), low + 0.6 * (high - low));
    const double at_share = slope(Z_ + share * d, d, tau);
    (at_share <= 0.0 ? low : high) = share;
    (at_share <= 0.0 ? at_low : at_high) = at_share;
    if (at_high * (high - low) <= -0.5 * at_low * low) return high;
    if (low > 0.0 && at_low >= 0.5 * slope_at_start) return low;
  }
  return low;
}

// d·∇Ψ.
double Solver::Work::slope(const Vec3& at, const Vec3& d, double tau) const noexcept {
  double slope = dot(at - C_, d);
  for (std::size_t i = 0; i < plane_count_; ++i) {
    const Plane& p = planes_[i];
    slope -= answer(p, p.t + tau * p.residual(at), tau) * dot(p.q, d);
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    const Span& p = spans_[i];
    slope -= dot(answer(p, p.u + tau * p.residual(at), tau), d);
  }
  for (std::size_t i = 0; i < corner_count_; ++i) {
    const Corner& p = corners_[i];
    slope -= dot(shortened(p.pull(at, tau).w / (1.0 + p.compliance * tau), p.s), d);
  }
  return slope;
}

void Solver::Work::keep() noexcept {
  kept_Z_ = Z_;
  for (std::size_t i = 0; i < plane_count_; ++i) kept_planes_n_[i] = planes_[i].t;
  for (std::size_t i = 0; i < all_spans_; ++i) kept_spans_n_[i] = spans_[i].u;
  std::copy_n(corners_.get(), corner_count_, kept_corners_.get());
}

void Solver::Work::restore() noexcept {
  Z_ = kept_Z_;
  for (std::size_t i = 0; i < plane_count_; ++i) planes_[i].t = kept_planes_n_[i];
  for (std::size_t i = 0; i < all_spans_; ++i) spans_[i].u = kept_spans_n_[i];
  std::copy_n(kept_corners_.get(), corner_count_, corners_.get());
}

// Whether an error `off_n` of a residual shows in the bound, by its root: with the strength of a force, and of a drag with its
// unbounded stiffness.
bool Solver::Work::shows_in_gap(double off_n, double longest_n, double gamma) const noexcept {
  return !(off_n * (longest_n + gamma * off_n) <= shown_by_root * wanted_n_ * wanted_n_);
}

// A single primitive, or a plane and a line with one direction (a surface and its friction), whose spans are orthogonal: a
// sweep is the closed form. The balance moves by no more than C, the anchors and the strengths do, so its error is their
// rounding and the sweep's own. Where that would show in the duality gap, with its root, the stages are used.
bool Solver::Work::in_closed_form() noexcept {
  if (corner_count_ > 0) return corner_in_closed_form();
  const bool one = plane_count_ + all_spans_ == 1;
  const bool surface = plane_count_ == 1 && line_count_ == 1 && all_spans_ == 1 && planes_[0].q == spans_[0].q;
  if (!one && !surface) return false;
  double size = C_size_ + directed_size_n_, longest = 0.0, gamma = 0.0;
  if (plane_count_ == 1) size += planes_[0].size + planes_[0].s, longest = planes_[0].s, gamma = planes_[0].gamma;
  if (all_spans_ == 1) {
    size += spans_[0].size + spans_[0].s;
    longest = std::max(longest, spans_[0].s), gamma = std::max(gamma, spans_[0].gamma);
  }
  const double rounding = (16.0 + directed_terms_) * epsilon * size;
  if (shows_in_gap(epsilon * size, longest, gamma)) return false;
  // From zero forces: a warm start's can be far longer, a drag's above all, and would leave their rounding.
  Z_ = C_;
  if (plane_count_ == 1) planes_[0].t = 0.0;
  if (all_spans_ == 1) spans_[0].u = {};
  sweep();
  best_Z_ = Z_;
  best_bound_n_ = rounding;
  best_stage_ = 1, iterations_ = 1;
  done_ = true;
  return true;
}

// A corner with a single holding facet, with or without a line along that facet's normal, is that plane: at its nearest
// feasible point, all its other facets are satisfied. The newest facet is tried first.
bool Solver::Work::corner_in_closed_form() noexcept {
  if (corner_count_ > 1 || plane_count_ > 0 || all_spans_ > 1 || line_count_ != all_spans_) return false;
  Corner& corner = corners_[0];
  for (std::size_t j = corner.normals.size(); j-- > 0;) {
    const Vec3& n = corner.normals[j];
    if (all_spans_ == 1 && spans_[0].q != n) continue;
    const double longest = std::max(corner.s, all_spans_ == 1 ? spans_[0].s : 0.0);
    double size = C_size_ + directed_size_n_ + std::abs(corner.b[j]) + corner.s;
    if (all_spans_ == 1) size += spans_[0].size + spans_[0].s;
    if (shows_in_gap(epsilon * size, longest, all_spans_ == 1 ? spans_[0].gamma : 0.0)) return false;
    const double behind = std::max(0.0, corner.residual(j, C_));
    const double t = std::min(behind / (1.0 + corner.compliance), corner.s);
    const Vec3 u = all_spans_ == 1 ? answer(spans_[0], spans_[0].residual(C_), 1.0) : Vec3{};
    const Vec3 Z = C_ + t * n + u;
    const Vec3 foot = C_ + behind * n + u;
    const double rounding = (16.0 + directed_terms_) * epsilon * size;
    bool left = true;
    for (std::size_t i = 0; i < corner.normals.size(); ++i) {
      left = left && (i == j || corner.residual(i, foot) < -(rounding + detail::plane_rounding * std::abs(corner.b[i])));
    }
    if (!left) continue;
    corner.face.size = 0;
    corner.face.take(static_cast<int>(j), n);
    corner.u = t * n, corner.t[0] = t;
    if (all_spans_ == 1) spans_[0].u = u;
    best_Z_ = Z;
    best_bound_n_ = rounding;
    best_stage_ = 1, iterations_ = 1;
    done_ = true;
    return true;
  }
  return false;
}

void Solver::Work::solve() noexcept {
  if (in_closed_form()) return;
  if (warm_) keep();
  Z_ = sum();
  sweep();
  // More than three at once rarely converge after a sweep, and the proof costs as much as a sweep.
  if (plane_count_ + span_count_ + corner_count_ <= 3) {
    Z_ = sum();
    if (certify(1)) return;
  } else if (!warm_) {
    sweep();
  }
  // A round without proof is repeated from its end, after a sweep. Either a few rounds find the balance, or they cycle.
  int in_vain = plane_count_ + span_count_ + corner_count_ > many ? 1 : 0;
  for (int i = 0; i < max_rounds && in_vain < max_rounds_in_vain; ++i) {
    if (i > 0) {
      recentre();
      Z_ = sum();
      sweep();
    }
    const double before = best_bound_n_;
    if (round()) return;
    if (i == 0 && warm_ && solve_from_before()) return;
    if (!(best_bound_n_ < 0.5 * before)) ++in_vain;
  }
  augmented_lagrangian();
}

// Warm start from the forces and the proxy's motion of the previous balance, which are nearly the new ones: together they show
// which primitives slip, and in which direction, even if they slip little. The forces alone do not.
bool Solver::Work::solve_from_before() noexcept {
  restore();
  Z_ = k_ * moved_m_;
  for (int i = 0; i < max_rounds_from_before; ++i) {
    if (round()) return true;
  }
  return false;
}

// Steps of the active set until one settles, and the proof.
bool Solver::Work::round() noexcept {
  for (int i = 0; i < max_steps_in_a_round; ++i) {
    const Step step = active_set_step();
    if (step == Step::settled) break;
    if (step == Step::cut && i + 1 < max_steps_in_a_round) Z_ = sum(), sweep();
  }
  return certify(2);
}

void Solver::Work::give(Balance& balance, Vec3& remainder_m, Vec3* forces_n) noexcept {
  if (done_) {
    for (std::size_t i = 0; i < plane_count_; ++i) forces_n[planes_[i].index] = planes_[i].t * planes_[i].q;
    for (std::size_t i = 0; i < all_spans_; ++i) forces_n[spans_[i].index] = spans_[i].across(spans_[i].u);
    for (std::size_t i = 0; i < corner_count_; ++i) corners_[i].give(forces_n);
  }
  const bool any = best_bound_n_ < std::numeric_limits<double>::max();
  bool free = true;
  for (std::size_t i = 0; i < primitives_.size(); ++i) {
    if (primitives_[i].kind == PrimitiveKind::directed) {
      forces_n[i] = primitives_[i].strength_n * primitives_[i].direction;
    } else if (!done_) {
      forces_n[i] = any ? best_forces_n_[i] : Vec3{};
    }
    free = free && forces_n[i] == Vec3{};
  }
  const Vec3 z_m = by_k_ * best_Z_;
  // In free space the proxy is the probe, to the bit: the damper detects free space by that.
  balance.position_m = free && any ? probe_m_ : best_origin_m_ + z_m;
  moved_m_ = balance.position_m - start_m_;
  remainder_m = (best_origin_m_ - balance.position_m) + z_m;
  // The last term is for by_k_ and for the remainder, which rounds where the proxy is far from the origin.
  const double bound_m = best_bound_n_ * by_k_ * (1.0 + 2.0 * epsilon) + size_of(remainder_m) + 2.0 * epsilon * size_of(z_m);
  balance.error_bound_m = bound_m < std::numeric_limits<double>::max() ? bound_m : std::numeric_limits<double>::max();
  balance.status = balance.error_bound_m <= exact_bound_m ? BalanceStatus::exact : BalanceStatus::capped;
  balance.stage = best_stage_;
  balance.iterations = iterations_;
}

Solver::Solver(std::size_t capacity)
    : capacity_(capacity),
      forces_(std::make_unique<Vec3[]>(capacity)),
      ids_(std::make_unique<PrimitiveId[]>(capacity)),
      work_(std::make_unique<Work>(capacity)) {}

Solver::~Solver() = default;

Balance Solver::solve(const PrimitiveSet& set, const Vec3& start_m, const Vec3& probe_m, double k, double T) noexcept {
  assert(set.size() <= capacity_);
  const bool fits = set.size() <= capacity_;
  const std::span<const Primitive> primitives = set.primitives().first(fits ? set.size() : 0);
  remainder_m_ = {};
  bool same = size_ == primitives.size();
  bool drags = false;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    same = same && ids_[i] == primitives[i].id;
    drags = drags || primitives[i].drag_ns_per_m > 0.0;
  }
  if (!same) match(primitives);

  const bool time_usable = !drags || (std::isfinite(T) && T > 0.0);
  if (!fits || !(k >= softest_n_per_m && k <= stiffest_n_per_m) || !time_usable || !usable(start_m) || !usable(probe_m)) {
    std::fill_n(forces_.get(), size_, Vec3{});
    return {usable(start_m) ? start_m : Vec3{}, std::numeric_limits<double>::max(), BalanceStatus::bad_input, 0, 0};
  }
  // Without primitives the proxy is the probe, to the bit.
  if (primitives.empty()) return {probe_m, 0.0, BalanceStatus::exact, 0, 0};

  work_->pose(primitives, forces_.get(), start_m, probe_m, k, T);
  work_->solve();
  Balance balance;
  work_->give(balance, remainder_m_, forces_.get());
  return balance;
}

// Maps the forces of the last balance to the order of this set, by id; zero for new primitives.
void Solver::match(std::span<const Primitive> primitives) noexcept {
  Vec3* const matched = work_->spare_forces();
  std::size_t next = 0;  // after the last match: sets rarely change their order
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    matched[i] = {};
    for (std::size_t step = 0; step < size_; ++step) {
      if (next >= size_) next = 0;
      const std::size_t j = next++;
      if (ids_[j] == primitives[i].id) {
        matched[i] = forces_[j];
        break;
      }
    }
  }
  size_ = primitives.size();
  for (std::size_t i = 0; i < size_; ++i) ids_[i] = primitives[i].id, forces_[i] = matched[i];
}

Balance solve_once(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                   double time_step_s) {
  Solver solver(std::max<std::size_t>(1, primitives.size()));
  return solver.solve(primitives, start_m, probe_m, stiffness_n_per_m, time_step_s);
}

}  // namespace palpa
