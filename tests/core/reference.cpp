#include "tests/core/reference.h"

#include <algorithm>
#include <vector>

namespace palpa::test {

namespace {

constexpr double certified_m = 1e-14;

template <class T>
T root(T x) {
  return x > T(0) ? static_cast<T>(std::sqrt(x)) : T(0);
}
#if defined(__SIZEOF_FLOAT128__)
// From the root in double: two corrections, each of which doubles the digits.
template <>
Quad root(Quad x) {
  if (!(x > 0)) return 0;
  if (x < Quad(1e-290)) return root(x * Quad(0x1p960)) * Quad(0x1p-480);
  if (x > Quad(1e290)) return root(x * Quad(0x1p-960)) * Quad(0x1p480);
  const double y = std::sqrt(static_cast<double>(x));
  const double half = 0.5 / y;
  Quad r = y;
  for (int i = 0; i < 2; ++i) r += (x - r * r) * half;
  return r;
}
#endif

template <class T>
struct V {
  T x{}, y{}, z{};
  V() = default;
  V(T a, T b, T c) : x(a), y(b), z(c) {}
  template <class S>
  explicit V(const V<S>& v) : x(v.x), y(v.y), z(v.z) {}
  explicit V(const Vec3& v) : x(v.x), y(v.y), z(v.z) {}
};
template <class T>
V<T> operator+(const V<T>& a, const V<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
V<T> operator-(const V<T>& a, const V<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
V<T> operator*(T f, const V<T>& a) {
  return {f * a.x, f * a.y, f * a.z};
}
template <class T>
T dot(const V<T>& a, const V<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
T length(const V<T>& a) {
  return root(dot(a, a));
}
template <class T>
T positive(T a) {
  return a > T(0) ? a : T(0);
}

// One primitive about the current point, all lengths multiplied by k so that they are forces: the energy
// times k is 1/2|Z − C|² + Σ s|R| + γ/2 |R|² with R the residual, γ = c/(kT).
//
// A plane keeps its residual and its force as numbers along its normal, with sign, in R.x and u.x; a
// line's vectors have no part along it.
template <class T>
struct Item {
  PrimitiveKind kind;
  V<T> q;
  T s;
  T gamma;
  V<T> R;
  V<T> u;
};

template <class T>
V<T> across(const V<T>& q, const V<T>& a) {
  return a - dot(q, a) * q;
}

// What a change of Z by `dz` takes off the residual.
template <class T>
V<T> seen(const Item<T>& item, const V<T>& dz) {
  switch (item.kind) {
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
  for (const Primitive& p : problem.primitives) {
    V<T> q(p.direction);
    if (p.kind != PrimitiveKind::point) q = (T(1) / length(q)) * q;
    if (p.kind == PrimitiveKind::directed) {
      state.C = state.C + T(p.strength_n) * q;
      continue;
    }
    Item<T> item{p.kind, q, T(p.strength_n), T(0), {}, {}};
    if (p.drag_ns_per_m > 0.0) item.gamma = T(p.drag_ns_per_m) / (state.k * T(problem.time_step_s));
    item.R = seen(item, state.k * (V<T>(p.position_m) - x_m));
    state.items.push_back(item);
  }
  return state;
}

// The maximiser over u of u·R − φ*(u) − |u − u₀|²/(2τ), given v = u₀ + τR; and its stiffness, as its part
// along e = v/|v| and its part across.
template <class T>
struct Answer {
  V<T> u;
  V<T> e;
  T along{};
  T side{};
};

template <class T>
Answer<T> answer(const Item<T>& item, const V<T>& residual, T tau) {
  V<T> v = item.u + tau * residual;
  const T drag = item.gamma > T(0) ? item.gamma / (tau + item.gamma) : T(0);
  if (item.kind == PrimitiveKind::plane) {
    if (!(v.x > T(0))) return {};
    if (v.x <= item.s) return {v, {}, tau, {}};
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

// Symmetric 3×3 matrix.
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
  H.xx += a.side, H.yy += a.side, H.zz += a.side;
  if (item.kind == PrimitiveKind::line) H.add_outer(-a.side, item.q);
  if (a.along != a.side) H.add_outer(a.along - a.side, a.e);
}

template <class T>
bool finite(const V<T>& a) {
  const T sum = a.x + a.y + a.z;
  return sum - sum == T(0);
}

// −(Z − C − Σ answer) at Z = dz: the force left over in the augmented problem.
template <class T>
V<T> left_over(const State<T>& state, const V<T>& dz, T tau) {
  V<T> f = state.C - dz;
  for (const Item<T>& item : state.items) f = f + on_proxy(item, answer(item, item.R - seen(item, dz), tau).u);
  return f;
}

template <class T>
void shift(State<T>& state, const V<T>& dz) {
  for (Item<T>& item : state.items) item.R = item.R - seen(item, dz);
  state.C = state.C - dz;
  state.x_m = state.x_m + (T(1) / state.k) * dz;
}

// Minimises the augmented problem for one τ by Newton's method. The residuals are kept about the current
// point, so that τR keeps its digits. `relative` is the rounding at which to stop.
template <class T>
int minimise(State<T>& state, T tau, T relative, int most_steps) {
  int steps = 0;
  T before = T(-1);
  for (; steps < most_steps; ++steps) {
    Stiffness<T> H;
    V<T> f = state.C;
    T size = length(state.C);
    for (const Item<T>& item : state.items) {
      const Answer<T> a = answer(item, item.R, tau);
      f = f + on_proxy(item, a.u);
      size += item.s;
      add_stiffness(H, item, a);
    }
    const T left = length(f);
    if (!(left > relative * size)) break;
    // Rounding: the last step no longer helped, and it was a full one.
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
      // By turns the secant and the middle.
      const T secant = low + (high - low) * (slope_low / (slope_low - slope_high));
      t = i % 2 == 0 ? secant : T(0.5) * (low + high);
    }
    shift(state, t * d);
  }
  return steps;
}

template <class T>
void take_forces(State<T>& state, T tau) {
  for (Item<T>& item : state.items) item.u = answer(item, item.R, tau).u;
}

// One primitive's share of the duality gap [N m], in the form without cancellation: with l = min(|u|, s),
// m = (|u| − s)₊ T/c, e = u/|u|
//   point, line:  (s − l)|r| + l|r|/2 |e − r/|r||² + c/2T |r − m e|²
//   plane:        (s − l) r₊ + |u| r₋ + c/2T (r₊ − m)²
// `u` is projected on what the primitive can exert first.
Quad gap_of(const Primitive& p, const V<Quad>& q, const V<Quad>& x_m, Quad T, V<Quad>& u) {
  const Quad s = p.strength_n;
  const Quad c = p.drag_ns_per_m > 0.0 ? Quad(p.drag_ns_per_m) / T : Quad(0);
  const V<Quad> d = V<Quad>(p.position_m) - x_m;
  if (p.kind == PrimitiveKind::plane) {
    Quad t = positive(dot(q, u));
    if (c == 0 && t > s) t = s;
    u = t * q;
    const Quad r = dot(q, d);
    const Quad l = t < s ? t : s;
    Quad gap = (s - l) * positive(r) + t * positive(-r);
    if (c > 0) {
      const Quad miss = positive(r) - (t - l) / c;
      gap += c / 2 * miss * miss;
    }
    return gap;
  }
  V<Quad> r = d;
  if (p.kind == PrimitiveKind::line) u = across(q, u), r = across(q, d);
  Quad size = length(u);
  if (c == 0 && size > s) u = (s / size) * u, size = s;
  const Quad l = size < s ? size : s;
  const Quad reach = length(r);
  const V<Quad> e = size > 0 ? (1 / size) * u : V<Quad>{};
  Quad gap = (s - l) * reach;
  if (l > 0 && reach > 0) {
    const V<Quad> chord = e - (1 / reach) * r;
    gap += l * reach * dot(chord, chord) / 2;
  }
  if (c > 0) {
    const V<Quad> miss = r - ((size - l) / c) * e;
    gap += c / 2 * dot(miss, miss);
  }
  return gap;
}

V<Quad> unit(const Primitive& p) {
  const V<Quad> q(p.direction);
  return p.kind == PrimitiveKind::point ? V<Quad>{} : (1 / length(q)) * q;
}

// (ρ + √(ρ² + 4kε))/(2k), with `force(i)` the force of primitive i.
template <class Force>
Quad bound_of(const Problem& problem, const V<Quad>& x_m, Force force) {
  const Quad k = problem.stiffness_n_per_m;
  V<Quad> left = k * (x_m - V<Quad>(problem.probe_m));
  Quad gap = 0;
  for (std::size_t i = 0; i < problem.primitives.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    const V<Quad> q = unit(p);
    V<Quad> u;
    if (p.kind == PrimitiveKind::directed) {
      u = Quad(p.strength_n) * q;
    } else {
      u = force(i);
      gap += gap_of(p, q, x_m, problem.time_step_s, u);
    }
    left = left - u;
  }
  const Quad squared = dot(left, left);
  return (root(squared) + root(squared + 4 * k * gap)) / (2 * k);
}

Quad bound_of(const Problem& problem, const State<Quad>& state) {
  std::size_t next = 0;
  return bound_of(problem, state.x_m, [&](std::size_t) {
    const Item<Quad>& item = state.items[next++];
    return on_proxy(item, item.u);
  });
}

// Raises τ from one power of ten to another, keeps the best point that was proven.
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
  V<double> moved;  // sums what double would lose in x_m
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

double plain_bound_m(const Problem& problem, std::span<const Vec3> forces_n, const Vec3& position_m, const Vec3& remainder_m) {
  // A double can say s e only to a few ulp, which would cost s|R| ulp in the gap however good the answer is: a
  // force that is as long as its strength but for rounding counts as exactly so long.
  return static_cast<double>(bound_of(problem, V<Quad>(position_m) + V<Quad>(remainder_m), [&](std::size_t i) {
    const Primitive& p = problem.primitives[i];
    const V<Quad> u(forces_n[i]);
    const Quad length = root(dot(u, u)), s = p.strength_n;
    const bool full = p.drag_ns_per_m == 0.0 && length > 0 && length - s < Quad(2e-15) * s && s - length < Quad(2e-15) * s;
    return full ? (s / length) * u : u;
  }));
}

}  // namespace palpa::test
