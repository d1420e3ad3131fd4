#include "palpa/session/split.h"

#include <array>
#include <limits>
#include <utility>

#include "palpa/solver/corner.h"
#include "palpa/solver/double2.h"

namespace palpa {

// The least split
//
// Primitives that stick may exert any force u_i of a set U_i = s_i B_i: s its strength, B_i the unit ball (point), the unit
// disc across q (line), the segment from 0 to q (plane), the intersection of the unit ball and the cone of the normals that the
// proxy lies on (corner). The split shown is
//     minimise ½ Σ |u_i|²/s_i   over u_i ∈ U_i with Σ u_i = F,
// F the total of the given split. (A drag is zero without motion: φ*(u) = (T/2c)(|u| − s)₊² is constant for forces within the
// strength, so such a primitive shares like any other. An elastic primitive shares nothing: its deflection determines its
// force.) With a multiplier λ for the total, each force is independent:
//     u_i(λ) = s_i b_i(λ),   b_i(λ) = the point of B_i next to λ,
// and λ maximises the concave, once differentiable dual
//     g(λ) = F·λ − Σ s_i h_i(λ),   ∇h_i = b_i   (Huber's functions),   ∇g = F − Σ u_i(λ) =: e.
// Three unknowns for any number of primitives, independent of their order.
//
// Newton's method on e(λ) = 0. All is divided by Σs, so that weights sum to 1:
//   1. D = Σ w_i ∂b_i/∂λ is a sum of outer products of single directions, w·aaᵀ:
//        point, line  inside |v| ≤ 1 (v = the part of λ in its span): every direction of its span, w
//                     outside: the directions across v, w/|v|
//        plane        0 ≤ q·λ ≤ 1: q, w; else none
//        corner       as a point within the span of the cone's face that is next to λ
//   2. δ = Σ_j v_j (v_j·e)/(σ_j² + ρ_j) over the principal directions v_j of D. Directions in which e is rounding are
//      left out: they may be held by no primitive. ρ_j = 1e-4 (v_j·e)² bounds steps where all are at their limits
//      (D = 0), and vanishes faster than e.
//   3. g is concave along δ, so its slope δ·e only falls. Where it has fallen below 0, shorten δ to where it is about 0:
//      shorter, a plane that sets in on the way would be missed again; longer, cones at their limits send λ round in
//      circles.
// Where F is on the border of ΣU_i, λ may be at infinity (a plane that pushes across the direction in which a point is at its
// limit). Then e shrinks by about a third with each step, to rounding or until the step cap: the remainder is returned.
//
// Primitives that are parallel up to a small angle θ are distinguished by a λ of length 1/θ, and D has the eigenvalue σ² = θ².
// Two measures keep that from spoiling the total: D is never formed, only its triangular root R (RᵀR = D), from its directions
// by rotations; and λ, and its products with directions, are kept to 106 bits.

namespace {

constexpr double ulp = std::numeric_limits<double>::epsilon();
// [1] Caps on Newton steps and on halvings of a step. More: longer worst case; fewer: a larger remainder, which is returned.
constexpr int max_steps = 100;
constexpr int max_shortenings = 60;
// Damping of a Newton step, by the squared error. More: smaller steps, more of them; less: steps along flat directions
// overshoot.
constexpr double ridge_per_error_squared = 1e-4;
constexpr double least_ridge = 1e-30;  // damping at the end: below it R is rounding
constexpr int jacobi_sweeps = 8;       // [1] six suffice for any 3×3 matrix; fewer: columns not orthogonal

using detail::Double2;

Double2 sum_with_product(const Double2& a, const Double2& b, double c) noexcept { return sum(a, product(b, c)); }

struct WideVec3 {
  Double2 x, y, z;
};

WideVec3 sum(const WideVec3& a, const Vec3& b) noexcept {
  return {sum(a.x, Double2{b.x}), sum(a.y, Double2{b.y}), sum(a.z, Double2{b.z})};
}

Vec3 value(const WideVec3& a) noexcept { return {rounded(a.x), rounded(a.y), rounded(a.z)}; }

double dot(const WideVec3& a, const Vec3& b) noexcept {
  return rounded(sum_with_product(sum_with_product(product(a.x, b.x), a.y, b.y), a.z, b.z));
}
Vec3 cross(const WideVec3& a, const Vec3& b) noexcept {
  return {rounded(sum_with_product(product(a.y, b.z), a.z, -b.y)), rounded(sum_with_product(product(a.z, b.x), a.x, -b.z)),
          rounded(sum_with_product(product(a.x, b.y), a.y, -b.x))};
}

// Primitive, or corner with all of its facets, that can share.
struct Sharer {
  std::span<const Primitive> whole;
  std::span<Vec3> forces_n;
  const Balance& balance;
  double s = 0.0;  // [N] its largest force here

  const Primitive& first() const noexcept { return whole[0]; }
  bool is_corner() const noexcept { return whole.size() > 1; }
};

// Part of λ in a primitive's span, q taken as a unit vector; for a plane q·λ, a number.
struct Demand {
  Vec3 v;
  double along_normal = 0.0;
};

Demand demand(const Primitive& p, const WideVec3& lambda) noexcept {
  const Vec3& q = p.direction;
  switch (p.kind) {
    case PrimitiveKind::point: return {value(lambda)};
    case PrimitiveKind::line: return {cross(q, cross(lambda, q)) / norm_squared(q)};
    case PrimitiveKind::plane:
    case PrimitiveKind::corner: return {{}, dot(lambda, q) / norm(q)};
    case PrimitiveKind::directed: break;
  }
  return {};
}

bool is_plane(const Primitive& p) noexcept { return p.kind == PrimitiveKind::plane || p.kind == PrimitiveKind::corner; }

// Point of a corner's cone next to λ: the least v with n·v ≥ n·λ for all normals at the proxy.
struct ConePoint {
  ConePoint(const Sharer& corner, const WideVec3& lambda) noexcept {
    std::array<Vec3, most_facets> normals;
    double c[most_facets];
    std::size_t count = 0;
    for (std::size_t i = 0; i < corner.whole.size(); ++i) {
      if (state_at(corner.whole[i], corner.balance) == PrimitiveState::off) continue;
      normals[count] = corner.whole[i].direction;
      c[count] = dot(lambda, normals[count]);
      facets[count++] = i;
    }
    foot = detail::foot_of({normals.data(), count}, c);
  }
  detail::CornerFoot foot;
  std::array<std::size_t, most_facets> facets;  // of the corner, in the order of the foot
};

// Largest force of a primitive here. A drag at rest within the balance's bound may add a little to its strength; keep it.
double limit_n(const Primitive& p, const Vec3& force_n) noexcept {
  return p.drag_ns_per_m > 0.0 ? std::clamp(norm(force_n), p.strength_n, largest_strength_n) : p.strength_n;
}

// b(λ): point of the unit set next to λ.
Vec3 nearest(const Sharer& sharer, const WideVec3& lambda) noexcept {
  if (sharer.is_corner()) return shortened(ConePoint(sharer, lambda).foot.w, 1.0);
  const Primitive& p = sharer.first();
  const Demand d = demand(p, lambda);
  return is_plane(p) ? (std::clamp(d.along_normal, 0.0, 1.0) / norm(p.direction)) * p.direction : shortened(d.v, 1.0);
}

// Writes s b(λ), of a corner by facet. Returns the sum.
Vec3 exert(const Sharer& sharer, const WideVec3& lambda) noexcept {
  if (!sharer.is_corner()) return sharer.forces_n[0] = sharer.s * nearest(sharer, lambda);
  const ConePoint point(sharer, lambda);
  const double share = sharer.s / std::max(1.0, norm(point.foot.w));
  std::fill(sharer.forces_n.begin(), sharer.forces_n.end(), Vec3{});
  Vec3 sum_n;
  for (int a = 0; a < point.foot.face.size; ++a) {
    const std::size_t i = point.facets[static_cast<std::size_t>(point.foot.face.facet[a])];
    sum_n += sharer.forces_n[i] = share * point.foot.t[a] * sharer.whole[i].direction;
  }
  return sum_n;
}

WideVec3 wide(const Vec3& a) noexcept { return sum(WideVec3{}, a); }

// Two unit vectors perpendicular to `a` and to each other.
std::array<Vec3, 2> across(const Vec3& a) noexcept {
  const Vec3 e = normalized(a);
  const Vec3 first = normalized(std::abs(e.x) < 0.6 ? cross(e, Vec3{1, 0, 0}) : cross(e, Vec3{0, 1, 0}));
  return {first, cross(e, first)};
}

// Upper triangular R with RᵀR = Σ w aaᵀ.
class Root {
 public:
  void add(double weight_root, const Vec3& a) noexcept {
    double row[3] = {weight_root * a.x, weight_root * a.y, weight_root * a.z};
    for (int k = 0; k < 3; ++k) {
      const double length = std::sqrt(r_[k][k] * r_[k][k] + row[k] * row[k]);
      if (!(length > 0.0)) continue;
      const double c = r_[k][k] / length;
      const double s = row[k] / length;
      for (int j = k; j < 3; ++j) {
        const double above = r_[k][j];
        r_[k][j] = c * above + s * row[j];
        row[j] = c * row[j] - s * above;
      }
    }
  }

  // δ of step 2. One-sided Jacobi: rotations of column pairs make R's columns orthogonal, with the σ_j as lengths; the
  // identity, rotated along, becomes the v_j.
  Vec3 newton_step(const Vec3& e, double rounding) const noexcept {
    Vec3 column[3] = {{r_[0][0], 0, 0}, {r_[0][1], r_[1][1], 0}, {r_[0][2], r_[1][2], r_[2][2]}};
    Vec3 v[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int sweep = 0; sweep < jacobi_sweeps; ++sweep) {
      for (const auto& [i, j] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
        const double both = dot(column[i], column[j]);
        const double difference = norm_squared(column[j]) - norm_squared(column[i]);
        if (both == 0.0) continue;
        const double zeta = difference / (2.0 * both);
        const double t = std::copysign(1.0, zeta) / (std::abs(zeta) + std::sqrt(1.0 + zeta * zeta));
        const double c = 1.0 / std::sqrt(1.0 + t * t);
        for (Vec3* turned : {column, v}) {
          const Vec3 before = turned[i];
          turned[i] = c * (before - t * turned[j]);
          turned[j] = c * (turned[j] + t * before);
        }
      }
    }
    Vec3 delta;
    for (int j = 0; j < 3; ++j) {
      const double left = dot(v[j], e);
      const double ridge = std::max(least_ridge, ridge_per_error_squared * left * left);
      if (std::abs(left) > rounding) delta += (left / (norm_squared(column[j]) + ridge)) * v[j];
    }
    return delta;
  }

 private:
  double r_[3][3] = {};
};

// Adds w ∂b/∂λ of a corner: of a point, within the span of its face.
void add_derivative_of_corner(Root& root, const Sharer& corner, double weight, const WideVec3& lambda) noexcept {
  const detail::CornerFoot foot = ConePoint(corner, lambda).foot;
  const double length = norm(foot.w);
  detail::Face left;  // of the span, behind v itself if v is too long
  const bool inside = length <= 1.0;
  if (!inside) left.take(0, foot.w / length);
  for (int i = 0; i < foot.face.size && left.size < foot.face.size; ++i) left.take(0, foot.face.q[i]);
  for (int i = inside ? 0 : 1; i < left.size; ++i) root.add(std::sqrt(inside ? weight : weight / length), left.q[i]);
}

void add_derivative(Root& root, const Sharer& sharer, double weight, const WideVec3& lambda) noexcept {
  if (sharer.is_corner()) return add_derivative_of_corner(root, sharer, weight, lambda);
  const Primitive& p = sharer.first();
  const Demand d = demand(p, lambda);
  if (is_plane(p)) {
    if (d.along_normal >= 0.0 && d.along_normal <= 1.0) root.add(std::sqrt(weight), normalized(p.direction));
    return;
  }
  const double length = norm(d.v);
  const bool inside = length <= 1.0;
  const double weight_root = std::sqrt(inside ? weight : weight / length);
  if (p.kind == PrimitiveKind::line) {
    if (!inside) return root.add(weight_root, normalized(cross(p.direction, d.v)));
    for (const Vec3& a : across(p.direction)) root.add(weight_root, a);
    return;
  }
  for (const Vec3& a : across(inside ? Vec3{1, 0, 0} : d.v)) root.add(weight_root, a);
  if (inside) root.add(weight_root, {1, 0, 0});
}

struct Rest {
  Vec3 e;             // remainder of the total
  double size = 0.0;  // of all terms: scale of the rounding of their sum
};

bool is_sound(const Primitive& p) noexcept {
  return p.strength_n > 0.0 && p.strength_n <= largest_strength_n && is_finite(p.position_m) &&
         (p.kind == PrimitiveKind::point || std::abs(norm_squared(p.direction) - 1.0) < 1e-6);
}

// Calls `visit` with each primitive, or whole corner, that can share.
template <class Visit>
void for_each_sharer(std::span<const Primitive> primitives, const Balance& balance, std::span<Vec3> forces_n, Visit visit) {
  for (std::size_t i = 0; i < primitives.size();) {
    const bool corner = primitives[i].kind == PrimitiveKind::corner;
    const std::size_t size = corner ? whole_of(primitives, i).size() : 1;
    const std::span<Vec3> own_n = forces_n.empty() ? forces_n : forces_n.subspan(i, size);
    if (corner ? is_exchangeable(primitives, i, balance) : is_exchangeable(primitives[i], balance)) {
      visit(Sharer{primitives.subspan(i, size), own_n, balance, own_n.empty() ? 0.0 : limit_n(primitives[i], own_n[0])});
    }
    i += size;
  }
}

}  // namespace

bool is_exchangeable(const Primitive& p, const Balance& balance) noexcept {
  return is_sound(p) && !p.is_elastic() && state_at(p, balance) == PrimitiveState::stick;
}

bool is_exchangeable(std::span<const Primitive> primitives, std::size_t i, const Balance& balance) noexcept {
  const std::span<const Primitive> whole = whole_of(primitives, i);
  return whole.size() <= most_facets && std::all_of(whole.begin(), whole.end(), is_sound) && !whole[0].is_elastic() &&
         state_at(primitives, i, balance) == PrimitiveState::stick;
}

bool split_is_shared(std::span<const Primitive> primitives, const Balance& balance) noexcept {
  // Gram–Schmidt over the spans of the sticking primitives: three directions at most.
  std::array<Vec3, 3> basis;
  std::size_t rank = 0;
  std::size_t held = 0;
  const auto take = [&](Vec3 direction) {
    ++held;
    for (std::size_t b = 0; b < rank; ++b) direction -= dot(direction, basis[b]) * basis[b];
    if (rank < 3 && norm(direction) > 1e-6) basis[rank++] = normalized(direction);
  };
  for_each_sharer(primitives, balance, {}, [&](const Sharer& sharer) {
    const Primitive& p = sharer.first();
    if (sharer.is_corner()) {
      detail::Face span;
      for (const Primitive& facet : sharer.whole) {
        if (state_at(facet, balance) != PrimitiveState::off) span.take(0, facet.direction);
      }
      for (int i = 0; i < span.size; ++i) take(span.q[i]);
      return;
    }
    if (is_plane(p)) return take(p.direction);
    for (const Vec3& a : across(p.kind == PrimitiveKind::line ? p.direction : Vec3{1, 0, 0})) take(a);
    if (p.kind == PrimitiveKind::point) take({1, 0, 0});
  });
  return held > rank;
}

double least_split(std::span<const Primitive> primitives, const Balance& balance, std::span<Vec3> forces_n) noexcept {
  const std::size_t n = primitives.size();
  const auto for_each_exchangeable = [&](auto&& visit) { for_each_sharer(primitives, balance, forces_n.first(n), visit); };

  double all_n = 0.0;  // Σs
  Vec3 total_n;        // F, as far as the primitives can exert it
  for (Vec3& force_n : forces_n.first(n)) {
    if (!is_finite(force_n)) force_n = {};
  }
  for_each_exchangeable([&](const Sharer& sharer) {
    Vec3 own_n;
    for (const Vec3& force_n : sharer.forces_n) own_n += force_n;
    all_n += sharer.s;
    total_n += sharer.s * nearest(sharer, wide(shortened(own_n, sharer.s) / sharer.s));
  });
  if (!(all_n > 0.0)) return 0.0;

  const auto rest_at = [&](const WideVec3& lambda) {
    Rest rest{total_n / all_n, norm(total_n) / all_n};
    for_each_exchangeable([&](const Sharer& sharer) {
      const Vec3 u = (sharer.s / all_n) * nearest(sharer, lambda);
      rest.e -= u;
      rest.size += norm(u);
    });
    return rest;
  };

  const double few_ulp = (4.0 + static_cast<double>(n)) * ulp;
  WideVec3 lambda, best;
  Rest rest = rest_at(lambda);
  double least = norm(rest.e);
  for (int step = 0; step < max_steps && norm(rest.e) > few_ulp * rest.size; ++step) {
    Root root;
    for_each_exchangeable([&](const Sharer& sharer) { add_derivative(root, sharer, sharer.s / all_n, lambda); });
    const Vec3 delta = root.newton_step(rest.e, few_ulp * rest.size);
    const double slope = dot(delta, rest.e);
    if (!is_finite(delta) || !(slope > 0.0)) break;
    double low = 0.0, high = 1.0, share = 1.0;
    Rest next = rest_at(sum(lambda, delta));
    double next_slope = dot(delta, next.e);
    for (int i = 0; i < max_shortenings && (next_slope < -0.1 * slope || (share < 1.0 && next_slope > 0.5 * slope)); ++i) {
      (next_slope < 0.0 ? high : low) = share;
      share = 0.5 * (low + high);
      next = rest_at(sum(lambda, share * delta));
      next_slope = dot(delta, next.e);
    }
    lambda = sum(lambda, share * delta);
    rest = next;
    if (norm(rest.e) < least) {
      least = norm(rest.e);
      best = lambda;
    }
  }

  Vec3 left_n = total_n;
  for_each_exchangeable([&](const Sharer& sharer) { left_n -= exert(sharer, best); });
  return norm(left_n);
}

ShownForces::ShownForces(std::size_t most_primitives) {
  primitives_.reserve(most_primitives);
  forces_n_.reserve(most_primitives);
  shared_.reserve(most_primitives);
}

std::span<const Vec3> ShownForces::of(std::span<const PlacedPrimitive> placed, const Balance& balance) noexcept {
  primitives_.clear();
  forces_n_.clear();
  for (const PlacedPrimitive& row : placed) {
    primitives_.push_back(row.primitive);
    forces_n_.push_back(row.force_n);
  }
  const bool balanced = balance.status == BalanceStatus::exact || balance.status == BalanceStatus::capped;
  const bool shared = balanced && split_is_shared(primitives_, balance);
  if (shared) least_split(primitives_, balance, forces_n_);
  shared_.assign(placed.size(), false);
  for (std::size_t i = 0; shared && i < placed.size(); ++i) shared_[i] = is_exchangeable(primitives_, i, balance);
  return forces_n_;
}

}  // namespace palpa
