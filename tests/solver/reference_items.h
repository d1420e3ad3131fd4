// Primitives about a point in any floating point, their answers to a pull, and Newton's method on the augmented Lagrangian: of
// the references of a point and of a tool.
#pragma once

#include <span>

#include "tests/solver/reference_geometry.h"

namespace palpa::test::reference {

inline constexpr double certified_m = 1e-14;

// One primitive about the current point, all lengths multiplied by k so that they are forces: the energy times k is 1/2|Z − C|²
// + Σ s|R| + γ/2 |R|² with R the residual, γ = c/(kT).
//
// A plane keeps its residual and its force as signed numbers along its normal, in R.x and u.x; a line's vectors have no part
// along it. A corner has the residuals r of its facets instead of R.
template <class T>
struct Item {
  PrimitiveKind kind;
  V<T> q;
  T s;
  T gamma;
  V<T> R;
  V<T> u;
  std::vector<V<T>> normals{};
  std::vector<T> r{};
  std::vector<T> t{};
  T compliance{};  // k over the stiffness of elastic primitives
  std::size_t size() const { return std::max<std::size_t>(1, normals.size()); }
};

// Decrease of the residual by a change `dz` of Z.
template <class T>
V<T> seen(const Item<T>& item, const V<T>& dz) {
  switch (item.kind) {
    case PrimitiveKind::corner: return {};
    case PrimitiveKind::plane: return {dot(item.q, dz), T(0), T(0)};
    case PrimitiveKind::line: return across(item.q, dz);
    default: return dz;
  }
}

// The primitive, or the whole corner, that begins at `i`, about x_m; not for directed forces.
template <class T>
Item<T> item_at(const std::vector<Primitive>& primitives, std::size_t i, T k, T time_step_s, const V<T>& x_m) {
  const Primitive& p = primitives[i];
  Item<T> item{p.kind, unit<T>(p), T(p.strength_n), T(0), {}, {}};
  if (p.is_elastic()) item.compliance = k / T(p.stiffness_n_per_m);
  if (p.kind == PrimitiveKind::corner) {
    for (const std::size_t end = end_of_corner(primitives, i); i < end; ++i) {
      item.normals.push_back(unit<T>(primitives[i]));
      item.r.push_back(k * dot(item.normals.back(), V<T>(primitives[i].position_m) - x_m));
      item.t.push_back(T(0));
    }
    return item;
  }
  if (p.drag_ns_per_m > 0.0) item.gamma = T(p.drag_ns_per_m) / (k * time_step_s);
  item.R = seen(item, k * (V<T>(p.position_m) - x_m));
  return item;
}

// The maximiser over u of u·R − φ*(u) − |u − u₀|²/(2τ), given v = u₀ + τR; and its stiffness, as its part along e = v/|v| and
// its part across.
template <class T>
struct Answer {
  V<T> u;
  V<T> e;
  T along{};
  T side{};
  LeastWay<T> least{};  // of a corner: e is within the span of its q, and so is `side`
};

template <class T>
Answer<T> answer_of_corner(const Item<T>& item, const V<T>& dz, T tau) {
  std::vector<T> c;
  for (std::size_t i = 0; i < item.normals.size(); ++i) {
    c.push_back(tau * (item.r[i] - dot(item.normals[i], dz)) + dot(item.normals[i], item.u));
  }
  Answer<T> a;
  a.least = Projection<T>(item.normals, c).least_way();
  const T yields = T(1) + item.compliance * tau;
  for (T& t : a.least.t) t = t / yields;
  for (std::size_t i = 0; i < item.normals.size(); ++i) a.u = a.u + a.least.t[i] * item.normals[i];
  const T squared = dot(a.u, a.u);
  a.along = a.side = tau / yields;
  if (squared > item.s * item.s) {
    const T demanded = root(squared), share = item.s / demanded;
    a.e = (T(1) / demanded) * a.u;
    a.u = share * a.u;
    for (T& t : a.least.t) t = share * t;
    a.along = T(0), a.side = tau / yields * share;
  }
  return a;
}

template <class T>
Answer<T> answer(const Item<T>& item, const V<T>& dz, T tau) {
  if (item.kind == PrimitiveKind::corner) return answer_of_corner(item, dz, tau);
  V<T> v = item.u + tau * (item.R - seen(item, dz));
  const T drag = item.gamma > T(0) ? item.gamma / (tau + item.gamma) : T(0);
  if (item.kind == PrimitiveKind::plane) {
    if (!(v.x > T(0))) return {};
    const T yields = T(1) + item.compliance * tau;
    v.x = v.x / yields;
    if (v.x <= item.s) return {v, {}, tau / yields, {}};
    return {{item.s + drag * (v.x - item.s), T(0), T(0)}, {}, tau * drag, {}};
  }
  if (item.kind == PrimitiveKind::line) v = across(item.q, v);
  const T squared = dot(v, v);
  if (squared <= item.s * item.s) return {v, {}, tau, tau};
  const T demanded = root(squared);
  const T given = item.s + drag * (demanded - item.s);
  const T share = given / demanded;
  return {share * v, (T(1) / demanded) * v, tau * drag, tau * share};
}

template <class T>
V<T> on_proxy(const Item<T>& item, const V<T>& u) {
  return item.kind == PrimitiveKind::plane ? u.x * item.q : u;
}

template <class T>
void take_force(Item<T>& item, T tau) {
  const Answer<T> a = answer(item, V<T>{}, tau);
  item.u = a.u;
  item.t = a.least.t;
}

template <class T>
void shift(Item<T>& item, const V<T>& dz) {
  item.R = item.R - seen(item, dz);
  for (std::size_t i = 0; i < item.r.size(); ++i) item.r[i] -= dot(item.normals[i], dz);
}

// The forces of a primitive or of a corner's facets, at the end of `forces`.
template <class T>
void append_forces(const Item<T>& item, std::vector<V<T>>& forces) {
  if (item.kind != PrimitiveKind::corner) forces.push_back(on_proxy(item, item.u));
  for (std::size_t j = 0; j < item.normals.size(); ++j) forces.push_back(item.t[j] * item.normals[j]);
}

// Symmetric 3×3 matrix.
template <class T>
struct Stiffness {
  T xx{}, yy{}, zz{}, xy{}, xz{}, yz{};
  void add_outer(T f, const V<T>& e) {
    const V<T> g = f * e;
    xx += g.x * e.x, yy += g.y * e.y, zz += g.z * e.z;
    xy += g.x * e.y, xz += g.x * e.z, yz += g.y * e.z;
  }
};

template <class T>
void add_stiffness(Stiffness<T>& H, const Item<T>& item, const Answer<T>& a) {
  if (item.kind == PrimitiveKind::plane) {
    if (a.along > T(0)) H.add_outer(a.along, item.q);
    return;
  }
  if (!(a.side > T(0))) return;
  if (item.kind == PrimitiveKind::corner) {
    for (const V<T>& q : a.least.q) H.add_outer(a.side, q);
    if (a.along != a.side) H.add_outer(a.along - a.side, a.e);
    return;
  }
  H.xx += a.side, H.yy += a.side, H.zz += a.side;
  if (item.kind == PrimitiveKind::line) H.add_outer(-a.side, item.q);
  if (a.along != a.side) H.add_outer(a.along - a.side, a.e);
}

template <class T>
bool finite(const V<T>& a) {
  const T sum = a.x + a.y + a.z;
  return sum - sum == T(0);
}

// The residual force of the augmented problem at Z = 0, the size of its terms, and Newton's step.
template <class T, class Vector>
struct Newton {
  Vector left;
  T size;
  Vector step;
};

// Minimises the augmented problem of a State for one τ by Newton's method. The residuals are kept about the current point, so
// that τR keeps its digits. `relative`: the rounding that stops it.
template <class State, class T>
int minimise(State& state, T tau, T relative, int most_steps) {
  int steps = 0;
  T before = T(-1);
  for (; steps < most_steps; ++steps) {
    const auto newton = state.newton(tau);
    const T left = length(newton.left);
    if (!(left > relative * newton.size)) break;
    // Rounding: a full last step brought no decrease.
    if (before >= T(0) && left >= before && left <= T(1e4) * relative * newton.size) break;
    before = left;
    const auto& d = newton.step;
    const T slope = dot(newton.left, d);  // of −Ψ along d; falls along d, for Ψ is convex
    if (!finite(d) || !(slope > T(0))) break;
    // Up to `low` Ψ has fallen by slope_low·low at least; from there to t it has risen by −now (t − low) at most.
    T t = T(1), low = T(0), high = T(0), slope_low = slope, slope_high = T(0);
    for (int i = 0; i < 120; ++i) {
      const T now = dot(state.left_over(t * d, tau), d);
      if (now >= T(0)) {
        if (high == T(0) || now <= T(0.5) * slope) break;
        low = t, slope_low = now;
      } else {
        if (-now * (t - low) <= T(0.5) * slope_low * low) break;
        high = t, slope_high = now;
      }
      // Secant and bisection alternate.
      const T secant = low + (high - low) * (slope_low / (slope_low - slope_high));
      t = i % 2 == 0 ? secant : T(0.5) * (low + high);
    }
    state.shift_by(t * d);
  }
  return steps;
}

// Raises τ from one power of ten to another; `prove(state)` keeps the best proven point and returns its bound. Returns the
// number of Newton steps.
template <class State, class Prove>
int polish(State& state, double from, double factor, Quad enough, Prove prove) {
  constexpr double largest = 1e26;
  constexpr int most_rounds = 40;
  double tau = from;
  int at_largest = 0, steps = 0;
  for (int round = 0; round < most_rounds && at_largest < 6; ++round) {
    steps += minimise<State, Quad>(state, tau, 1e-32, 60);
    for (Item<Quad>& item : state.items) take_force<Quad>(item, tau);
    if (tau >= 1e17 && prove(state) <= enough) break;
    if (tau >= largest) ++at_largest;
    tau = std::min(tau * factor, largest);
  }
  return steps;
}

}  // namespace palpa::test::reference
