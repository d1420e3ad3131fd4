#include "palpa/solver/split.h"

#include <array>
#include <limits>
#include <utility>

#include "palpa/solver/corner.h"
#include "palpa/solver/double2.h"
#include "palpa/solver/pose_solver.h"

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

// Multiplier of a point's total force in three dimensions, of a tool's total wrench in six.
template <std::size_t N>
using Wrench = std::array<double, N>;
template <std::size_t N>
using WideWrench = std::array<Double2, N>;

template <std::size_t N>
WideWrench<N> sum(WideWrench<N> a, const Wrench<N>& b) noexcept {
  for (std::size_t i = 0; i < N; ++i) a[i] = sum(a[i], Double2{b[i]});
  return a;
}
template <std::size_t N>
double dot(const WideWrench<N>& a, const Wrench<N>& b) noexcept {
  Double2 all = product(a[0], b[0]);
  for (std::size_t i = 1; i < N; ++i) all = sum(all, product(a[i], b[i]));
  return rounded(all);
}
template <std::size_t N>
double dot(const Wrench<N>& a, const Wrench<N>& b) noexcept {
  double all = a[0] * b[0];
  for (std::size_t i = 1; i < N; ++i) all += a[i] * b[i];
  return all;
}
template <std::size_t N>
double length_of(const Wrench<N>& a) noexcept {
  if constexpr (N == 3) return norm(Vec3{a[0], a[1], a[2]});
  return std::hypot(norm(Vec3{a[0], a[1], a[2]}), norm(Vec3{a[3], a[4], a[5]}));
}
// a + f b.
template <std::size_t N>
Wrench<N> plus(Wrench<N> a, double f, const Wrench<N>& b) noexcept {
  for (std::size_t i = 0; i < N; ++i) a[i] += f * b[i];
  return a;
}
template <std::size_t N>
Wrench<N> over(Wrench<N> a, double f) noexcept {
  for (double& one : a) one /= f;
  return a;
}
template <std::size_t N>
Wrench<N> times(double f, Wrench<N> a) noexcept {
  for (double& one : a) one *= f;
  return a;
}

// Primitive, or corner with all of its facets, that can share.
struct Sharer {
  std::span<const Primitive> whole;
  std::span<Vec3> forces_n;
  Balance balance;  // as its foot has it
  Vec3 beta;        // lever over turning radius; zero for a point
  double s = 0.0;   // [N] its largest force here

  bool is_in_cone() const noexcept { return whole[0].kind == PrimitiveKind::plane || whole[0].kind == PrimitiveKind::corner; }
  // Normal of facet i, zero if the proxy is off it.
  Vec3 normal(std::size_t i) const noexcept {
    return state_at(whole[i], balance) == PrimitiveState::off ? Vec3{} : whole[i].direction;
  }
};

// Wrench of a force at its foot: Jᵀu.
template <std::size_t N>
Wrench<N> wrench(const Sharer& sharer, const Vec3& u) noexcept {
  if constexpr (N == 3) {
    return {u.x, u.y, u.z};
  } else {
    const Vec3 torque = cross(sharer.beta, u);
    return {u.x, u.y, u.z, torque.x, torque.y, torque.z};
  }
}

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
template <std::size_t N>
detail::LeastWay projection(const Sharer& sharer, const WideWrench<N>& lambda) noexcept {
  detail::LeastWay way;
  if (!sharer.is_in_cone()) {
    way.face = span_of(sharer);
    for (int i = 0; i < way.face.size; ++i) way.w += dot(lambda, wrench<N>(sharer, way.face.q[i])) * way.face.q[i];
    return way;
  }
  std::array<Vec3, most_facets> normals;
  double c[most_facets];
  for (std::size_t i = 0; i < sharer.whole.size(); ++i) {
    normals[i] = sharer.normal(i);
    c[i] = dot(lambda, wrench<N>(sharer, normals[i]));
  }
  return detail::least_way({normals.data(), sharer.whole.size()}, c);
}

// Writes s b(λ), of a corner by facet. Returns the sum.
template <std::size_t N>
Vec3 exert(const Sharer& sharer, const WideWrench<N>& lambda) noexcept {
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
template <std::size_t N>
class Root {
 public:
  void add(double weight_root, const Wrench<N>& a) noexcept {
    Wrench<N> row = times<N>(weight_root, a);
    for (std::size_t k = 0; k < N; ++k) {
      const double length = std::sqrt(r_[k][k] * r_[k][k] + row[k] * row[k]);
      if (!(length > 0.0)) continue;
      const double c = r_[k][k] / length;
      const double s = row[k] / length;
      for (std::size_t j = k; j < N; ++j) {
        const double above = r_[k][j];
        r_[k][j] = c * above + s * row[j];
        row[j] = c * row[j] - s * above;
      }
    }
  }

  // δ = Σ v_j (v_j·e)/(σ_j² + damping) over the principal directions v_j of D, without those in which e is rounding: they may
  // be held by no primitive. One-sided Jacobi: rotations of column pairs make R's columns orthogonal, with the σ_j as lengths;
  // the identity, rotated along, becomes the v_j.
  Wrench<N> newton_step(const Wrench<N>& e, double rounding) const noexcept {
    std::array<Wrench<N>, N> column{}, v{};
    for (std::size_t j = 0; j < N; ++j) {
      v[j][j] = 1.0;
      for (std::size_t i = 0; i <= j; ++i) column[j][i] = r_[i][j];
    }
    for (int sweep = 0; sweep < jacobi_sweeps; ++sweep) {
      for (std::size_t i = 0; i < N; ++i) {
        for (std::size_t j = i + 1; j < N; ++j) turn_pair(column, v, i, j);
      }
    }
    Wrench<N> delta{};
    for (std::size_t j = 0; j < N; ++j) {
      const double left = dot<N>(v[j], e);
      const double ridge = std::max(least_ridge, ridge_per_error_squared * left * left);
      if (std::abs(left) > rounding) delta = plus<N>(delta, left / (dot<N>(column[j], column[j]) + ridge), v[j]);
    }
    return delta;
  }

 private:
  static void turn_pair(std::array<Wrench<N>, N>& column, std::array<Wrench<N>, N>& v, std::size_t i, std::size_t j) noexcept {
    const double both = dot<N>(column[i], column[j]);
    const double difference = dot<N>(column[j], column[j]) - dot<N>(column[i], column[i]);
    if (both == 0.0) return;
    const double zeta = difference / (2.0 * both);
    const double t = std::copysign(1.0, zeta) / (std::abs(zeta) + std::sqrt(1.0 + zeta * zeta));
    const double c = 1.0 / std::sqrt(1.0 + t * t);
    for (std::array<Wrench<N>, N>* turned : {&column, &v}) {
      const Wrench<N> before = (*turned)[i];
      (*turned)[i] = times<N>(c, plus<N>(before, -t, (*turned)[j]));
      (*turned)[j] = times<N>(c, plus<N>((*turned)[j], t, before));
    }
  }

  std::array<std::array<double, N>, N> r_{};
};

// Remainder of the total at a λ, and the derivative of what is exerted.
template <std::size_t N>
struct Rest {
  Wrench<N> e{};
  double size = 0.0;  // of all terms: scale of the rounding of their sum
  Root<N> root;

  // Subtracts w b(λ), and adds w ∂b/∂λ: w along all of the face, or w/|v| across v if that is too long.
  void take(const Sharer& sharer, const detail::LeastWay& way, double weight) noexcept {
    const double length = norm(way.w);
    weight /= std::max(1.0, length);
    e = plus<N>(e, -1.0, wrench<N>(sharer, weight * way.w));
    size += weight * length;
    detail::Face left;
    if (length > 1.0) left.take(0, way.w / length);
    for (int i = 0; i < way.face.size && left.size < way.face.size; ++i) left.take(0, way.face.q[i]);
    for (int i = length > 1.0 ? 1 : 0; i < left.size; ++i) root.add(std::sqrt(weight), wrench<N>(sharer, left.q[i]));
  }
};

// Directions that are held: an orthonormal basis of their span.
template <std::size_t N>
class Basis {
 public:
  std::size_t size() const noexcept { return size_; }
  void take(Wrench<N> a) noexcept {
    if (size_ == N) return;
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t i = 0; i < size_; ++i) a = plus<N>(a, -dot<N>(q_[i], a), q_[i]);
    }
    const double length = std::sqrt(dot<N>(a, a));
    if (length > dependent) q_[size_++] = times<N>(1.0 / length, a);
  }

 private:
  static constexpr double dependent = 1e-12;  // [1] as of a corner's face
  std::array<Wrench<N>, N> q_{};
  std::size_t size_ = 0;
};

bool is_sound(const Primitive& p) noexcept {
  return p.strength_n > 0.0 && p.strength_n <= largest_strength_n && is_finite(p.position_m) &&
         (p.kind == PrimitiveKind::point || std::abs(norm_squared(p.direction) - 1.0) < 1e-6);
}

// Largest force of a primitive here. A drag at rest within the balance's bound may add a little to its strength; keep it.
double limit_n(const Primitive& p, const Vec3& force_n) noexcept {
  return p.drag_ns_per_m > 0.0 ? std::clamp(norm(force_n), p.strength_n, largest_strength_n) : p.strength_n;
}

// A balance to be split.
struct Held {
  std::span<const Primitive> primitives;
  const Balance& balance;
  const FeetOfRows& feet;

  Balance at_foot(std::size_t i) const noexcept {
    return feet.is_point() ? balance : balance_at_foot(balance, feet.levers_m[i], feet.turning_radius_m);
  }
};

// Calls `visit` with each primitive, or whole corner, that can share.
template <class Visit>
void for_each_sharer(const Held& held, std::span<Vec3> forces_n, Visit visit) {
  const std::span<const Primitive> primitives = held.primitives;
  for (std::size_t i = 0, size = 0; i < primitives.size(); i += size) {
    size = whole_of(primitives, i).size();
    const std::span<Vec3> own_n = forces_n.empty() ? forces_n : forces_n.subspan(i, size);
    const Balance at = held.at_foot(i);
    if (!is_exchangeable(primitives, i, at)) continue;
    const Vec3 beta = held.feet.is_point() ? Vec3{} : held.feet.levers_m[i] / held.feet.turning_radius_m;
    visit(Sharer{primitives.subspan(i, size), own_n, at, beta, own_n.empty() ? 0.0 : limit_n(primitives[i], own_n[0])});
  }
}

template <std::size_t N>
bool any_shared(const Held& held) noexcept {
  std::size_t count = 0;
  Basis<N> all;
  for_each_sharer(held, {}, [&](const Sharer& sharer) {
    const detail::Face span = span_of(sharer);
    count += static_cast<std::size_t>(span.size);
    for (int i = 0; i < span.size; ++i) all.take(wrench<N>(sharer, span.q[i]));
  });
  return count > all.size();
}

template <std::size_t N>
double split_of(const Held& held, std::span<Vec3> forces_n) noexcept {
  const std::size_t n = held.primitives.size();
  const auto for_each_exchangeable = [&](auto&& visit) { for_each_sharer(held, forces_n.first(n), visit); };

  double all_n = 0.0;   // Σs
  Wrench<N> total_n{};  // F, as far as the primitives can exert it
  for (Vec3& force_n : forces_n.first(n)) {
    if (!is_finite(force_n)) force_n = {};
  }
  for_each_exchangeable([&](const Sharer& sharer) {
    Vec3 own_n;
    for (const Vec3& force_n : sharer.forces_n) own_n += force_n;
    all_n += sharer.s;
    const Sharer at_centre{sharer.whole, sharer.forces_n, sharer.balance, {}, sharer.s};
    const Vec3 asked = shortened(own_n, sharer.s) / sharer.s;
    const Vec3 exerted = shortened(projection<3>(at_centre, sum<3>(WideWrench<3>{}, wrench<3>(at_centre, asked))).w, 1.0);
    total_n = plus<N>(total_n, 1.0, wrench<N>(sharer, sharer.s * exerted));
  });
  if (!(all_n > 0.0)) return 0.0;

  const auto rest_at = [&](const WideWrench<N>& lambda) {
    Rest<N> rest{over<N>(total_n, all_n), length_of<N>(total_n) / all_n};
    for_each_exchangeable([&](const Sharer& sharer) { rest.take(sharer, projection<N>(sharer, lambda), sharer.s / all_n); });
    return rest;
  };
  const double few_ulp = (4.0 + static_cast<double>(n)) * std::numeric_limits<double>::epsilon();
  WideWrench<N> lambda = sum<N>(WideWrench<N>{}, over<N>(total_n, all_n));
  Rest<N> rest = rest_at(lambda);
  for (int step = 0; step < max_steps && length_of<N>(rest.e) > few_ulp * rest.size; ++step) {
    Wrench<N> delta = rest.root.newton_step(rest.e, few_ulp * rest.size);
    const Wrench<N> e = rest.e;
    if (!std::isfinite(length_of<N>(delta)) || !(dot<N>(delta, e) > 0.0)) break;
    rest = rest_at(sum<N>(lambda, delta));
    for (int i = 0; i < max_halvings && dot<N>(delta, rest.e) < -0.1 * dot<N>(delta, e); ++i)
      rest = rest_at(sum<N>(lambda, delta = times<N>(0.5, delta)));
    lambda = sum<N>(lambda, delta);
  }

  Wrench<N> left_n = total_n;
  for_each_exchangeable(
      [&](const Sharer& sharer) { left_n = plus<N>(left_n, -1.0, wrench<N>(sharer, exert<N>(sharer, lambda))); });
  return length_of<N>(left_n);
}

}  // namespace

bool is_exchangeable(std::span<const Primitive> primitives, std::size_t i, const Balance& balance) noexcept {
  const std::span<const Primitive> whole = whole_of(primitives, i);
  return whole.size() <= most_facets && std::all_of(whole.begin(), whole.end(), is_sound) && !whole[0].is_elastic() &&
         state_at(primitives, i, balance) == PrimitiveState::stick;
}

bool split_is_shared(std::span<const Primitive> primitives, const Balance& balance, const FeetOfRows& feet) noexcept {
  const Held held{primitives, balance, feet};
  return feet.is_point() ? any_shared<3>(held) : any_shared<6>(held);
}

double least_split(std::span<const Primitive> primitives, const Balance& balance, std::span<Vec3> forces_n,
                   const FeetOfRows& feet) noexcept {
  const Held held{primitives, balance, feet};
  return feet.is_point() ? split_of<3>(held, forces_n) : split_of<6>(held, forces_n);
}

ShownForces::ShownForces(std::size_t most_primitives) {
  primitives_.reserve(most_primitives);
  levers_m_.reserve(most_primitives);
  forces_n_.reserve(most_primitives);
  shared_.reserve(most_primitives);
}

std::span<const Vec3> ShownForces::of(std::span<const PlacedPrimitive> placed, const SubStep& step) noexcept {
  primitives_.clear();
  levers_m_.clear();
  forces_n_.clear();
  for (const PlacedPrimitive& row : placed) {
    primitives_.push_back(row.primitive);
    levers_m_.push_back(row.lever_m);
    forces_n_.push_back(row.force_n);
  }
  const Balance& balance = step.balance;
  const FeetOfRows feet{levers_m_, step.turning_radius_m};
  const bool balanced = balance.status == BalanceStatus::exact || balance.status == BalanceStatus::capped;
  const bool shared = balanced && split_is_shared(primitives_, balance, feet);
  if (shared) least_split(primitives_, balance, forces_n_, feet);
  shared_.assign(placed.size(), false);
  for (std::size_t i = 0; shared && i < placed.size(); ++i)
    shared_[i] = is_exchangeable(primitives_, i, Held{primitives_, balance, feet}.at_foot(i));
  return forces_n_;
}

}  // namespace palpa
