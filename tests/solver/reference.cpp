#include "tests/solver/reference.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/solver/reference_bound.h"
#include "tests/solver/reference_items.h"

namespace palpa::test {

using namespace reference;

namespace {

// By LDLᵀ of 1 + H.
template <class T>
V<T> solved(const Stiffness<T>& H, const V<T>& b) {
  const T xx = T(1) + H.xx, l21 = H.xy / xx, l31 = H.xz / xx;
  T d2 = T(1) + H.yy - l21 * H.xy;
  if (!(d2 > T(1))) d2 = T(1);
  const T h = H.yz - l31 * H.xy;
  const T l32 = h / d2;
  T d3 = T(1) + H.zz - l31 * H.xz - l32 * h;
  if (!(d3 > T(1))) d3 = T(1);
  const T y1 = b.x, y2 = b.y - l21 * y1, y3 = b.z - l31 * y1 - l32 * y2;
  const T z = y3 / d3, y = y2 / d2 - l32 * z;
  return {y1 / xx - l21 * y - l31 * z, y, z};
}

template <class T>
struct State {
  std::vector<Item<T>> items;
  V<T> x_m;  // the current point; Z = 0 here
  V<T> C;
  T k;

  State(const Problem& problem, const V<T>& at_m)
      : x_m(at_m), C(T(problem.stiffness_n_per_m) * (V<T>(problem.probe_m) - at_m)), k(problem.stiffness_n_per_m) {
    for (std::size_t i = 0; i < problem.primitives.size();) {
      const Primitive& p = problem.primitives[i];
      if (p.kind == PrimitiveKind::directed) {
        C = C + T(p.strength_n) * unit<T>(p);
        ++i;
        continue;
      }
      items.push_back(item_at<T>(problem.primitives, i, k, problem.time_step_s, x_m));
      i += items.back().size();
    }
  }
  Newton<T, V<T>> newton(T tau) const {
    Stiffness<T> H;
    V<T> f = C;
    T size = length(C);
    for (const Item<T>& item : items) {
      const Answer<T> a = answer(item, V<T>{}, tau);
      f = f + on_proxy(item, a.u);
      size += item.s;
      add_stiffness(H, item, a);
    }
    return {f, size, solved(H, f)};
  }
  // −(Z − C − Σ answer) at Z = dz: the residual force of the augmented problem.
  V<T> left_over(const V<T>& dz, T tau) const {
    V<T> f = C - dz;
    for (const Item<T>& item : items) f = f + on_proxy(item, answer(item, dz, tau).u);
    return f;
  }
  void shift_by(const V<T>& dz) {
    for (Item<T>& item : items) shift(item, dz);
    C = C - dz;
    x_m = x_m + (T(1) / k) * dz;
  }
};

Quad bound_at(const Problem& problem, const State<Quad>& state) {
  std::vector<V<Quad>> forces;
  std::size_t next = 0;
  while (forces.size() < problem.primitives.size()) {
    if (problem.primitives[forces.size()].kind == PrimitiveKind::directed) {
      forces.emplace_back();
    } else {
      append_forces(state.items[next++], forces);
    }
  }
  return bound_of(problem, state.x_m, forces);
}

}  // namespace

Reference reference_balance(const Problem& problem) {
  Reference best;
  best.bound_m = DBL_MAX;
  const auto prove = [&](const State<Quad>& state) {
    const Quad bound = bound_at(problem, state);
    if (bound < best.bound_m) {
      best.bound_m = bound;
      best.x_m[0] = state.x_m.x, best.x_m[1] = state.x_m.y, best.x_m[2] = state.x_m.z;
    }
    return best.bound_m;
  };

  State<double> rough(problem, V<double>(problem.start_m));
  V<double> moved;  // accumulates digits that double would lose in x_m
  for (double tau = 1e2; tau <= 1e10; tau *= 1e2) {
    rough.x_m = {};
    minimise<State<double>, double>(rough, tau, 1e-15, 40);
    moved = moved + rough.x_m;
    for (Item<double>& item : rough.items) take_force<double>(item, tau);
  }
  if (finite(moved)) {
    State<Quad> state(problem, V<Quad>(problem.start_m) + V<Quad>(moved));
    for (std::size_t i = 0; i < state.items.size(); ++i) state.items[i].u = V<Quad>(rough.items[i].u);
    best.iterations += polish(state, 1e12, 1e6, Quad(certified_m) / 10, prove);
  }
  if (!(best.bound_m <= Quad(certified_m))) {
    State<Quad> state(problem, V<Quad>(problem.start_m));
    best.iterations += polish(state, 1e3, 10.0, Quad(certified_m) / 10, prove);
  }
  best.certified = best.bound_m <= Quad(certified_m);
  return best;
}

double error_m(const Reference& reference, const Vec3& position_m) {
  return static_cast<double>(length(V<Quad>(reference.x_m[0], reference.x_m[1], reference.x_m[2]) - V<Quad>(position_m)));
}

}  // namespace palpa::test
