#include "tests/solver/reference.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/solver/reference_bound.h"

namespace palpa::test {

using namespace reference;

namespace {

constexpr double certified_m = 1e-14;

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

template <class T>
struct State {
  std::vector<Item<T>> items;
  V<T> x_m;  // the current point; Z = 0 here
  V<T> C;
  T k;
};

template <class T>
State<T> state_at(const Problem& problem, const V<T>& x_m) {
  State<T> state;
  state.k = problem.stiffness_n_per_m;
  state.x_m = x_m;
  state.C = state.k * (V<T>(problem.probe_m) - x_m);
  state.items.reserve(problem.primitives.size());
  for (std::size_t i = 0; i < problem.primitives.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    const V<T> q = unit<T>(p);
    if (p.kind == PrimitiveKind::directed) {
      state.C = state.C + T(p.strength_n) * q;
      continue;
    }
    Item<T> item{p.kind, q, T(p.strength_n), T(0), {}, {}};
    if (p.is_elastic()) item.compliance = state.k / T(p.stiffness_n_per_m);
    if (p.kind == PrimitiveKind::corner) {
      const std::size_t end = end_of_corner(problem, i);
      for (; i < end; ++i) {
        const Primitive& facet = problem.primitives[i];
        item.normals.push_back(unit<T>(facet));
        item.r.push_back(state.k * dot(item.normals.back(), V<T>(facet.position_m) - x_m));
        item.t.push_back(T(0));
      }
      --i;
      state.items.push_back(item);
      continue;
    }
    if (p.drag_ns_per_m > 0.0) item.gamma = T(p.drag_ns_per_m) / (state.k * T(problem.time_step_s));
    item.R = seen(item, state.k * (V<T>(p.position_m) - x_m));
    state.items.push_back(item);
  }
  return state;
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
struct Stiffness {
  T xx{1}, yy{1}, zz{1}, xy{}, xz{}, yz{};
  void add_outer(T f, const V<T>& e) {
    const V<T> g = f * e;
    xx += g.x * e.x, yy += g.y * e.y, zz += g.z * e.z;
    xy += g.x * e.y, xz += g.x * e.z, yz += g.y * e.z;
  }
  // By LDLᵀ; the matrix is not below the identity.
  V<T> solve(const V<T>& b) const {
    const T l21 = xy / xx, l31 = xz / xx;
    T d2 = yy - l21 * xy;
    if (!(d2 > T(1))) d2 = T(1);
    const T h = yz - l31 * xy;
    const T l32 = h / d2;
    T d3 = zz - l31 * xz - l32 * h;
    if (!(d3 > T(1))) d3 = T(1);
    const T y1 = b.x, y2 = b.y - l21 * y1, y3 = b.z - l31 * y1 - l32 * y2;
    const T z = y3 / d3, y = y2 / d2 - l32 * z;
    return {y1 / xx - l21 * y - l31 * z, y, z};
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

// −(Z − C − Σ answer) at Z = dz: the residual force of the augmented problem.
template <class T>
V<T> left_over(const State<T>& state, const V<T>& dz, T tau) {
  V<T> f = state.C - dz;
  for (const Item<T>& item : state.items) f = f + on_proxy(item, answer(item, dz, tau).u);
  return f;
}

template <class T>
void shift(State<T>& state, const V<T>& dz) {
  for (Item<T>& item : state.items) {
    item.R = item.R - seen(item, dz);
    for (std::size_t i = 0; i < item.r.size(); ++i) item.r[i] -= dot(item.normals[i], dz);
  }
  state.C = state.C - dz;
  state.x_m = state.x_m + (T(1) / state.k) * dz;
}

// Minimises the augmented problem for one τ by Newton's method. The residuals are kept about the current point, so that τR
// keeps its digits. `relative`: the rounding that stops it.
template <class T>
int minimise(State<T>& state, T tau, T relative, int most_steps) {
  int steps = 0;
  T before = T(-1);
  for (; steps < most_steps; ++steps) {
    Stiffness<T> H;
    V<T> f = state.C;
    T size = length(state.C);
    for (const Item<T>& item : state.items) {
      const Answer<T> a = answer(item, V<T>{}, tau);
      f = f + on_proxy(item, a.u);
      size += item.s;
      add_stiffness(H, item, a);
    }
    const T left = length(f);
    if (!(left > relative * size)) break;
    // Rounding: a full last step brought no decrease.
    if (before >= T(0) && left >= before && left <= T(1e4) * relative * size) break;
    before = left;
    const V<T> d = H.solve(f);
    const T slope = dot(f, d);  // of −Ψ along d; falls along d, for Ψ is convex
    if (!finite(d) || !(slope > T(0))) break;
    // Up to `low` Ψ has fallen by slope_low·low at least; from there to t it has risen by −now (t − low) at most.
    T t = T(1), low = T(0), high = T(0), slope_low = slope, slope_high = T(0);
    for (int i = 0; i < 120; ++i) {
      const T now = dot(left_over(state, t * d, tau), d);
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
    shift(state, t * d);
  }
  return steps;
}

template <class T>
void take_forces(State<T>& state, T tau) {
  for (Item<T>& item : state.items) {
    const Answer<T> a = answer(item, V<T>{}, tau);
    item.u = a.u;
    item.t = a.least.t;
  }
}

Quad bound_of(const Problem& problem, const State<Quad>& state) {
  std::vector<V<Quad>> forces;
  std::size_t next = 0;
  for (std::size_t i = 0; i < problem.primitives.size(); ++i) {
    if (problem.primitives[i].kind == PrimitiveKind::directed) {
      forces.emplace_back();
      continue;
    }
    const Item<Quad>& item = state.items[next++];
    if (item.kind != PrimitiveKind::corner) forces.push_back(on_proxy(item, item.u));
    for (std::size_t j = 0; j < item.normals.size(); ++j) forces.push_back(item.t[j] * item.normals[j]);
    i += std::max<std::size_t>(1, item.normals.size()) - 1;
  }
  return bound_of(problem, state.x_m, forces);
}

// Raises τ from one power of ten to another, keeps the best proven point.
void polish(const Problem& problem, State<Quad>& state, double from, double factor, Reference& best) {
  constexpr double largest = 1e26;
  constexpr int most_rounds = 40;
  double tau = from;
  int at_largest = 0;
  for (int round = 0; round < most_rounds && at_largest < 6; ++round) {
    best.iterations += minimise<Quad>(state, tau, 1e-32, 60);
    take_forces<Quad>(state, tau);
    if (tau >= 1e17) {
      const Quad bound = bound_of(problem, state);
      if (bound < best.bound_m) {
        best.bound_m = bound;
        best.x_m[0] = state.x_m.x, best.x_m[1] = state.x_m.y, best.x_m[2] = state.x_m.z;
      }
      if (best.bound_m <= Quad(certified_m) / 10) return;
    }
    if (tau >= largest) ++at_largest;
    tau = std::min(tau * factor, largest);
  }
}

}  // namespace

Reference reference_balance(const Problem& problem) {
  Reference best;
  best.bound_m = DBL_MAX;

  State<double> rough = state_at<double>(problem, V<double>(problem.start_m));
  V<double> moved;  // accumulates digits that double would lose in x_m
  for (double tau = 1e2; tau <= 1e10; tau *= 1e2) {
    rough.x_m = {};
    minimise<double>(rough, tau, 1e-15, 40);
    moved = moved + rough.x_m;
    take_forces<double>(rough, tau);
  }
  if (finite(moved)) {
    State<Quad> state = state_at<Quad>(problem, V<Quad>(problem.start_m) + V<Quad>(moved));
    for (std::size_t i = 0; i < state.items.size(); ++i) state.items[i].u = V<Quad>(rough.items[i].u);
    polish(problem, state, 1e12, 1e6, best);
  }
  if (!(best.bound_m <= Quad(certified_m))) {
    State<Quad> state = state_at<Quad>(problem, V<Quad>(problem.start_m));
    polish(problem, state, 1e3, 10.0, best);
  }
  best.certified = best.bound_m <= Quad(certified_m);
  return best;
}

double error_m(const Reference& reference, const Vec3& position_m) {
  return static_cast<double>(length(V<Quad>(reference.x_m[0], reference.x_m[1], reference.x_m[2]) - V<Quad>(position_m)));
}

}  // namespace palpa::test
