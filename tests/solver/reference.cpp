#include "tests/solver/reference.h"

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

template <class T>
V<T> unit(const Primitive& p) {
  const V<T> q(p.direction);
  return p.kind == PrimitiveKind::point ? V<T>{} : (T(1) / length(q)) * q;
}

// The least w with n·w ≥ c for all facets, w = Σ t n, t ≥ 0, by a dual active set whose faces are orthonormal bases:
// what q spans, n_A = q T.
template <class T>
struct Foot {
  V<T> w;
  std::vector<T> t;
  std::vector<std::size_t> face;
  std::vector<V<T>> q;
};

template <class T>
T rounding_of();
template <>
double rounding_of<double>() {
  return 0x1p-52;
}
template <>
Quad rounding_of<Quad>() {
  return Quad(0x1p-112);
}

template <class T>
class Projection {
 public:
  Projection(const std::vector<V<T>>& normals, const std::vector<T>& c) : n_(normals), c_(c), t_(normals.size(), T(0)) {}

  Foot<T> foot() {
    for (int round = 0; round < 100; ++round) {
      const std::size_t j = furthest_behind();
      if (j == n_.size() || !press(j)) break;
    }
    settle();
    return {w_, t_, face_, q_};
  }

 private:
  std::size_t furthest_behind() const {
    T scale = length(w_);
    for (const T& c : c_) scale = std::max(scale, c > T(0) ? c : -c);
    T most = T(16) * rounding_of<T>() * scale;
    std::size_t worst = n_.size();
    for (std::size_t i = 0; i < n_.size(); ++i) {
      const T behind = c_[i] - dot(n_[i], w_);
      if (behind > most && std::find(face_.begin(), face_.end(), i) == face_.end()) most = behind, worst = i;
    }
    return worst;
  }

  // What `v` has along the basis, and beyond it.
  std::vector<T> parts(V<T>& v) const {
    std::vector<T> along(q_.size(), T(0));
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t i = 0; i < q_.size(); ++i) {
        const T part = dot(q_[i], v);
        along[i] += part;
        v = v - part * q_[i];
      }
    }
    return along;
  }
  std::vector<T> shares(std::vector<T> along) const {
    for (std::size_t i = along.size(); i-- > 0;) {
      for (std::size_t j = i + 1; j < along.size(); ++j) along[i] -= columns_[j][i] * along[j];
      along[i] /= columns_[i][i];
    }
    return along;
  }
  bool span(std::size_t j) {
    V<T> z = n_[j];
    std::vector<T> column = parts(z);
    const T beyond = length(z);
    if (face_.size() == 3 || !(beyond > independent())) return false;
    column.push_back(beyond);
    columns_.push_back(column);
    q_.push_back((T(1) / beyond) * z);
    face_.push_back(j);
    return true;
  }
  static T independent() { return T(1e4) * rounding_of<T>(); }

  // Presses facet j until it is reached, letting go of what would have to pull; false where nothing reaches it.
  bool press(std::size_t j) {
    T pressed(0);
    for (int round = 0; round < 20; ++round) {
      V<T> z = n_[j];
      const std::vector<T> r = shares(parts(z));
      const bool moves = face_.size() < 3 && length(z) > independent();
      std::size_t blocking = face_.size();
      for (std::size_t a = 0; a < face_.size(); ++a) {
        if (!(r[a] > T(0))) continue;
        if (blocking == face_.size() || t_[face_[a]] * r[blocking] < t_[face_[blocking]] * r[a]) blocking = a;
      }
      const bool blocked = blocking < face_.size();
      if (!moves && !blocked) return false;
      T step = moves ? (c_[j] - dot(n_[j], w_)) / dot(z, z) : t_[face_[blocking]] / r[blocking];
      const bool reaches = moves && !(blocked && t_[face_[blocking]] < step * r[blocking]);
      if (!reaches) step = t_[face_[blocking]] / r[blocking];
      for (std::size_t a = 0; a < face_.size(); ++a) t_[face_[a]] -= step * r[a];
      pressed += step;
      if (moves) w_ = w_ + step * z;
      if (reaches) {
        t_[j] = pressed;
        return span(j);
      }
      std::vector<std::size_t> rest = face_;
      t_[rest[blocking]] = T(0);
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(blocking));
      face_.clear(), q_.clear(), columns_.clear();
      for (const std::size_t i : rest) span(i);
    }
    return false;
  }

  void settle() {
    std::vector<T> y;
    w_ = {};
    for (std::size_t j = 0; j < face_.size(); ++j) {
      T rest = c_[face_[j]];
      for (std::size_t i = 0; i < j; ++i) rest -= columns_[j][i] * y[i];
      y.push_back(rest / columns_[j][j]);
      w_ = w_ + y[j] * q_[j];
    }
    const std::vector<T> t = shares(y);
    std::fill(t_.begin(), t_.end(), T(0));
    for (std::size_t a = 0; a < face_.size(); ++a) t_[face_[a]] = positive(t[a]);
  }

  const std::vector<V<T>>& n_;
  const std::vector<T>& c_;
  std::vector<T> t_;
  V<T> w_;
  std::vector<std::size_t> face_;
  std::vector<V<T>> q_;
  std::vector<std::vector<T>> columns_;
};

// One primitive about the current point, all lengths multiplied by k so that they are forces: the energy
// times k is 1/2|Z − C|² + Σ s|R| + γ/2 |R|² with R the residual, γ = c/(kT).
//
// A plane keeps its residual and its force as numbers along its normal, with sign, in R.x and u.x; a
// line's vectors have no part along it. A corner has the residuals r of its facets instead of R.
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
  T compliance{};  // k over the stiffness of what is elastic
};

template <class T>
V<T> across(const V<T>& q, const V<T>& a) {
  return a - dot(q, a) * q;
}

// What a change of Z by `dz` takes off the residual.
template <class T>
V<T> seen(const Item<T>& item, const V<T>& dz) {
  switch (item.kind) {
    case PrimitiveKind::corner: return {};
    case PrimitiveKind::plane: return {dot(item.q, dz), T(0), T(0)};
    case PrimitiveKind::line: return across(item.q, dz);
    default: return dz;
  }
}

std::size_t end_of_corner(const Problem& problem, std::size_t i) {
  const Primitive& first = problem.primitives[i];
  while (i < problem.primitives.size() && problem.primitives[i].kind == first.kind && problem.primitives[i].id == first.id) ++i;
  return i;
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

// The maximiser over u of u·R − φ*(u) − |u − u₀|²/(2τ), given v = u₀ + τR; and its stiffness, as its part
// along e = v/|v| and its part across.
template <class T>
struct Answer {
  V<T> u;
  V<T> e;
  T along{};
  T side{};
  Foot<T> foot{};  // of a corner: e is within what its q span, and so is `side`
};

template <class T>
Answer<T> answer_of_corner(const Item<T>& item, const V<T>& dz, T tau) {
  std::vector<T> c;
  for (std::size_t i = 0; i < item.normals.size(); ++i) {
    c.push_back(tau * (item.r[i] - dot(item.normals[i], dz)) + dot(item.normals[i], item.u));
  }
  Answer<T> a;
  a.foot = Projection<T>(item.normals, c).foot();
  const T yields = T(1) + item.compliance * tau;
  for (T& t : a.foot.t) t = t / yields;
  for (std::size_t i = 0; i < item.normals.size(); ++i) a.u = a.u + a.foot.t[i] * item.normals[i];
  const T squared = dot(a.u, a.u);
  a.along = a.side = tau / yields;
  if (squared > item.s * item.s) {
    const T demanded = root(squared), share = item.s / demanded;
    a.e = (T(1) / demanded) * a.u;
    a.u = share * a.u;
    for (T& t : a.foot.t) t = share * t;
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
  if (item.kind == PrimitiveKind::corner) {
    for (const V<T>& q : a.foot.q) H.add_outer(a.side, q);
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

// −(Z − C − Σ answer) at Z = dz: the force left over in the augmented problem.
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
      const Answer<T> a = answer(item, V<T>{}, tau);
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
  for (Item<T>& item : state.items) {
    const Answer<T> a = answer(item, V<T>{}, tau);
    item.u = a.u;
    item.t = a.foot.t;
  }
}

// Of what is elastic, with |r| = `reach` and a force of length t along r: φ + φ* − t|r| with v = min(κ|r|, s) what it should
// give, (v − t)(|r| − (v + t)/2κ), which where it holds is (κ|r| − t)²/2κ.
Quad elastic_gap(Quad reach, Quad t, Quad s, Quad stiffness) {
  const Quad v = stiffness * reach < s ? stiffness * reach : s;
  return v < s ? (v - t) * (v - t) / (2 * stiffness) : (v - t) * (reach - (v + t) / (2 * stiffness));
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
    if (p.is_elastic()) return elastic_gap(positive(r), t, s, p.stiffness_n_per_m) + t * positive(-r);
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

// A corner's share for the forces `u` of its facets, which are projected first: with w the way from x to the nearest free
// place, (s|w| − u·w) + Σ t (n·w − n·(a − x))₊ + (s/σ) v, v what x + w lacks of being free.
Quad gap_of_corner(std::span<const Primitive> facets, const V<Quad>& x_m, std::span<V<Quad>> u) {
  const Quad s = facets[0].strength_n;
  std::vector<V<Quad>> normals;
  std::vector<Quad> c, t;
  V<Quad> sum;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    normals.push_back(unit<Quad>(facets[i]));
    c.push_back(dot(normals[i], V<Quad>(facets[i].position_m) - x_m));
    t.push_back(positive(dot(normals[i], u[i])));
    sum = sum + t[i] * normals[i];
  }
  const Quad size = length(sum), share = size > s ? s / size : Quad(1);
  sum = share * sum;
  for (std::size_t i = 0; i < facets.size(); ++i) t[i] *= share, u[i] = t[i] * normals[i];
  const V<Quad> w = Projection<Quad>(normals, c).foot().w;
  const Quad reach = length(w), l = share * size;
  // Off the corner its force is s w/|w|. The t of doubles add up to that but for rounding, which counts as it: the rest of
  // it is left over.
  const bool elastic = facets[0].is_elastic();
  const Quad stiffness = elastic ? Quad(facets[0].stiffness_n_per_m) : Quad(0);
  const Quad given = elastic && stiffness * reach < s ? stiffness * reach : s;
  const V<Quad> full = reach > 0 ? (given / reach) * w : sum;
  Quad sizes = s;
  for (const Quad& one : t) sizes += one;
  if (length(full - sum) <= Quad(2e-15) * sizes) {
    std::fill(u.begin(), u.end(), V<Quad>{});
    u[0] = full;
    return 0;
  }
  Quad gap = elastic ? elastic_gap(reach, l, s, stiffness) : (s - l) * reach, lacking = 0;
  if (l > 0 && reach > 0) {
    const V<Quad> chord = (1 / l) * sum - (1 / reach) * w;
    gap += l * reach * dot(chord, chord) / 2;
  }
  for (std::size_t i = 0; i < facets.size(); ++i) {
    gap += t[i] * positive(dot(normals[i], w) - c[i]);
    lacking = std::max(lacking, c[i] - dot(normals[i], w));
  }
  const std::vector<Quad> ones(facets.size(), Quad(1));
  return gap + s * length(Projection<Quad>(normals, ones).foot().w) * lacking;
}

// (ρ + √(ρ² + 4kε))/(2k) for the forces of the primitives, in their order; those of directed ones are not read.
Quad bound_of(const Problem& problem, const V<Quad>& x_m, std::vector<V<Quad>> forces) {
  const Quad k = problem.stiffness_n_per_m;
  V<Quad> left = k * (x_m - V<Quad>(problem.probe_m));
  Quad gap = 0;
  for (std::size_t i = 0; i < problem.primitives.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    std::size_t end = i + 1;
    if (p.kind == PrimitiveKind::directed) {
      forces[i] = Quad(p.strength_n) * unit<Quad>(p);
    } else if (p.kind == PrimitiveKind::corner) {
      end = end_of_corner(problem, i);
      gap += gap_of_corner(std::span(problem.primitives).subspan(i, end - i), x_m, std::span(forces).subspan(i, end - i));
    } else {
      gap += gap_of(p, unit<Quad>(p), x_m, problem.time_step_s, forces[i]);
    }
    for (; i < end; ++i) left = left - forces[i];
    --i;
  }
  const Quad squared = dot(left, left);
  return (root(squared) + root(squared + 4 * k * gap)) / (2 * k);
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
  std::vector<V<Quad>> forces(forces_n.begin(), forces_n.end());
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Primitive& p = problem.primitives[i];
    const std::size_t end = p.kind == PrimitiveKind::corner ? end_of_corner(problem, i) : i + 1;
    V<Quad> sum;
    Quad sizes = 0;
    for (std::size_t j = i; j < end; ++j) sum = sum + forces[j], sizes += root(dot(forces[j], forces[j]));
    const Quad length = root(dot(sum, sum)), s = p.strength_n, rounding = Quad(2e-15) * std::max(s, sizes);
    const bool full = p.drag_ns_per_m == 0.0 && length > 0 && length - s < rounding && s - length < rounding;
    for (; i < end; ++i) forces[i] = full ? (s / length) * forces[i] : forces[i];
    --i;
  }
  return static_cast<double>(bound_of(problem, V<Quad>(position_m) + V<Quad>(remainder_m), forces));
}

}  // namespace palpa::test
