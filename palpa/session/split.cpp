#include "palpa/session/split.h"

#include <array>
#include <limits>
#include <utility>

#include "palpa/solver/corner.h"
#include "palpa/solver/double2.h"

namespace palpa {

// The least split
//
// A primitive that sticks, of strength s, may exert s b for any b of length ≤ 1 in its span (point, line) or in the cone of its
// normals (plane, corner). A drag is zero at rest; an elastic primitive shares nothing. A multiplier λ of the total F
// determines the split of least Σ|u|²/s, whatever the number and order of primitives: b(λ) is the projection of λ on the span
// or cone, shortened to 1, where e = F − Σ s b(λ) is zero. e is the gradient of a concave function of λ.
//
// Newton's method, all divided by Σs: λ += δ, with D δ = e and D = Σ w ∂b/∂λ, w the shares of the strengths; δ is halved while
// e behind it points back. Five projections with clamping are too few: they miss a mode's force by more than 1 % in 3 % of the
// shared ticks of recorded traces; 20 steps reach rounding in all.
//
// For primitives that are parallel up to an angle θ, or a total at the border of all that can be exerted, λ has a length of 1/θ
// or infinity, D eigenvalues of θ². Keeping the total to rounding there takes 106 bits for λ, and the root R of D in place of
// D.

namespace {

// [1] Caps on Newton steps and on halvings of a step. More: longer worst case; fewer: a larger remainder, which is returned.
constexpr int max_steps = 100;
constexpr int max_halvings = 60;
// Damping of a Newton step, by the squared error. More: smaller steps, more of them; less: steps along flat directions
// overshoot.
constexpr double ridge_per_error_squared = 1e-4;
constexpr double least_ridge = 1e-30;  // damping at the end: below it R is rounding
constexpr int jacobi_sweeps = 8;       // [1] six suffice for any 3×3 matrix; fewer: columns not orthogonal

using detail::Double2;

struct WideVec3 {
  Double2 x, y, z;
};

WideVec3 sum(const WideVec3& a, const Vec3& b) noexcept {
  return {sum(a.x, Double2{b.x}), sum(a.y, Double2{b.y}), sum(a.z, Double2{b.z})};
}
double dot(const WideVec3& a, const Vec3& b) noexcept {
  return rounded(sum(sum(product(a.x, b.x), product(a.y, b.y)), product(a.z, b.z)));
}

// Primitive, or corner with all of its facets, that can share.
struct Sharer {
  std::span<const Primitive> whole;
  std::span<Vec3> forces_n;
  const Balance& balance;
  double s = 0.0;  // [N] its largest force here

  bool is_in_cone() const noexcept { return whole[0].kind == PrimitiveKind::plane || whole[0].kind == PrimitiveKind::corner; }
  // Normal of facet i, zero if the proxy is off it.
  Vec3 normal(std::size_t i) const noexcept {
    return state_at(whole[i], balance) == PrimitiveState::off ? Vec3{} : whole[i].direction;
  }
};

// Span of a sharer's forces.
detail::Face span_of(const Sharer& sharer) noexcept {
  detail::Face span;
  if (sharer.is_in_cone()) {
    for (std::size_t i = 0; i < sharer.whole.size(); ++i) span.take(0, sharer.normal(i));
    return span;
  }
  const bool is_line = sharer.whole[0].kind == PrimitiveKind::line;
  const Vec3 e = is_line ? normalized(sharer.whole[0].direction) : Vec3{1, 0, 0};
  const Vec3 first = normalized(std::abs(e.x) < 0.6 ? cross(e, Vec3{1, 0, 0}) : cross(e, Vec3{0, 1, 0}));
  span.take(0, first);
  span.take(0, cross(e, first));
  if (!is_line) span.take(0, e);
  return span;
}

// Projection of λ on a sharer's span or cone.
detail::LeastWay projection(const Sharer& sharer, const WideVec3& lambda) noexcept {
  detail::LeastWay way;
  if (!sharer.is_in_cone()) {
    way.face = span_of(sharer);
    for (int i = 0; i < way.face.size; ++i) way.w += dot(lambda, way.face.q[i]) * way.face.q[i];
    return way;
  }
  std::array<Vec3, most_facets> normals;
  double c[most_facets];
  for (std::size_t i = 0; i < sharer.whole.size(); ++i) {
    normals[i] = sharer.normal(i);
    c[i] = dot(lambda, normals[i]);
  }
  return detail::least_way({normals.data(), sharer.whole.size()}, c);
}

// Writes s b(λ), of a corner by facet. Returns the sum.
Vec3 exert(const Sharer& sharer, const WideVec3& lambda) noexcept {
  const detail::LeastWay way = projection(sharer, lambda);
  const double share = sharer.s / std::max(1.0, norm(way.w));
  if (!sharer.is_in_cone()) return sharer.forces_n[0] = share * way.w;
  std::fill(sharer.forces_n.begin(), sharer.forces_n.end(), Vec3{});
  Vec3 sum_n;
  for (int a = 0; a < way.face.size; ++a) {
    const auto i = static_cast<std::size_t>(way.face.facet[a]);
    sum_n += sharer.forces_n[i] = share * way.t[a] * sharer.whole[i].direction;
  }
  return sum_n;
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

  // δ = Σ v_j (v_j·e)/(σ_j² + damping) over the principal directions v_j of D, without those in which e is rounding: they may
  // be held by no primitive. One-sided Jacobi: rotations of column pairs make R's columns orthogonal, with the σ_j as lengths;
  // the identity, rotated along, becomes the v_j.
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

// Remainder of the total at a λ, and the derivative of what is exerted.
struct Rest {
  Vec3 e;
  double size = 0.0;  // of all terms: scale of the rounding of their sum
  Root root;

  // Subtracts w b(λ), and adds w ∂b/∂λ: w along all of the face, or w/|v| across v if that is too long.
  void take(const detail::LeastWay& way, double weight) noexcept {
    const double length = norm(way.w);
    weight /= std::max(1.0, length);
    e -= weight * way.w;
    size += weight * length;
    detail::Face left;
    if (length > 1.0) left.take(0, way.w / length);
    for (int i = 0; i < way.face.size && left.size < way.face.size; ++i) left.take(0, way.face.q[i]);
    for (int i = length > 1.0 ? 1 : 0; i < left.size; ++i) root.add(std::sqrt(weight), left.q[i]);
  }
};

bool is_sound(const Primitive& p) noexcept {
  return p.strength_n > 0.0 && p.strength_n <= largest_strength_n && is_finite(p.position_m) &&
         (p.kind == PrimitiveKind::point || std::abs(norm_squared(p.direction) - 1.0) < 1e-6);
}

// Largest force of a primitive here. A drag at rest within the balance's bound may add a little to its strength; keep it.
double limit_n(const Primitive& p, const Vec3& force_n) noexcept {
  return p.drag_ns_per_m > 0.0 ? std::clamp(norm(force_n), p.strength_n, largest_strength_n) : p.strength_n;
}

// Calls `visit` with each primitive, or whole corner, that can share.
template <class Visit>
void for_each_sharer(std::span<const Primitive> primitives, const Balance& balance, std::span<Vec3> forces_n, Visit visit) {
  for (std::size_t i = 0, size = 0; i < primitives.size(); i += size) {
    size = whole_of(primitives, i).size();
    const std::span<Vec3> own_n = forces_n.empty() ? forces_n : forces_n.subspan(i, size);
    if (is_exchangeable(primitives, i, balance))
      visit(Sharer{primitives.subspan(i, size), own_n, balance, own_n.empty() ? 0.0 : limit_n(primitives[i], own_n[0])});
  }
}

}  // namespace

bool is_exchangeable(std::span<const Primitive> primitives, std::size_t i, const Balance& balance) noexcept {
  const std::span<const Primitive> whole = whole_of(primitives, i);
  return whole.size() <= most_facets && std::all_of(whole.begin(), whole.end(), is_sound) && !whole[0].is_elastic() &&
         state_at(primitives, i, balance) == PrimitiveState::stick;
}

bool split_is_shared(std::span<const Primitive> primitives, const Balance& balance) noexcept {
  int held = 0;
  detail::Face all;
  for_each_sharer(primitives, balance, {}, [&](const Sharer& sharer) {
    const detail::Face span = span_of(sharer);
    held += span.size;
    for (int i = 0; i < span.size; ++i) all.take(0, span.q[i]);
  });
  return held > all.size;
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
    total_n += sharer.s * shortened(projection(sharer, sum(WideVec3{}, shortened(own_n, sharer.s) / sharer.s)).w, 1.0);
  });
  if (!(all_n > 0.0)) return 0.0;

  const auto rest_at = [&](const WideVec3& lambda) {
    Rest rest{total_n / all_n, norm(total_n) / all_n};
    for_each_exchangeable([&](const Sharer& sharer) { rest.take(projection(sharer, lambda), sharer.s / all_n); });
    return rest;
  };
  const double few_ulp = (4.0 + static_cast<double>(n)) * std::numeric_limits<double>::epsilon();
  WideVec3 lambda = sum(WideVec3{}, total_n / all_n);
  Rest rest = rest_at(lambda);
  for (int step = 0; step < max_steps && norm(rest.e) > few_ulp * rest.size; ++step) {
    Vec3 delta = rest.root.newton_step(rest.e, few_ulp * rest.size);
    const Vec3 e = rest.e;
    if (!is_finite(delta) || !(dot(delta, e) > 0.0)) break;
    rest = rest_at(sum(lambda, delta));
    for (int i = 0; i < max_halvings && dot(delta, rest.e) < -0.1 * dot(delta, e); ++i)
      rest = rest_at(sum(lambda, delta *= 0.5));
    lambda = sum(lambda, delta);
  }

  Vec3 left_n = total_n;
  for_each_exchangeable([&](const Sharer& sharer) { left_n -= exert(sharer, lambda); });
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
