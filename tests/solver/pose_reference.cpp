#include "tests/solver/pose_reference.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/solver/reference_bound.h"
#include "tests/solver/reference_items.h"

namespace palpa::test {

using namespace reference;

namespace six {
namespace {

template <class T>
V<T> cross(const V<T>& a, const V<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class T>
struct Six {
  V<T> way, arc;
};
template <class T>
Six<T> operator+(const Six<T>& a, const Six<T>& b) {
  return {a.way + b.way, a.arc + b.arc};
}
template <class T>
Six<T> operator-(const Six<T>& a, const Six<T>& b) {
  return {a.way - b.way, a.arc - b.arc};
}
template <class T>
Six<T> operator*(T f, const Six<T>& a) {
  return {f * a.way, f * a.arc};
}
template <class T>
T dot(const Six<T>& a, const Six<T>& b) {
  return dot(a.way, b.way) + dot(a.arc, b.arc);
}
template <class T>
T length(const Six<T>& a) {
  return root(dot(a, a));
}
template <class T>
bool finite(const Six<T>& a) {
  return reference::finite(a.way) && reference::finite(a.arc);
}

// atan(tangent) for 0 <= tangent <= 1, by two steps of Newton's method for sin(a) = tangent cos(a), from the result in double;
// sine and cosine by their series.
Quad arc_tangent(Quad tangent) {
  Quad a = std::atan(static_cast<double>(tangent));
  for (int step = 0; step < 2; ++step) {
    Quad term = 1, cosine = 0, sine = 0;
    for (int n = 0; n < 40; ++n) {
      ((n % 2 == 0) ? cosine : sine) += (n / 2) % 2 == 0 ? term : -term;
      term *= a / (n + 1);
    }
    a += (tangent * cosine - sine) / (cosine + tangent * sine);
  }
  return a;
}

// π/2 − atan(x) = atan(1/x); π/2 = 2 atan(1).
Quad arc_tangent(Quad y, Quad x) { return y <= x ? arc_tangent(y / x) : 2 * arc_tangent(Quad(1)) - arc_tangent(x / y); }

// Rotation vector [rad] from one turn to another, for quaternions of any length.
V<Quad> rotation_between(const Turn& from, const Turn& to) {
  const Quad aw = to.w, bw = from.w;
  const V<Quad> a(to.x, to.y, to.z), b(from.x, from.y, from.z);
  // to · from⁻¹
  Quad w = aw * bw + dot(a, b);
  V<Quad> v = bw * a - aw * b - cross(a, b);
  if (w < 0) w = -w, v = Quad(-1) * v;
  const Quad sine = length(v);
  return sine > 0 ? (2 * arc_tangent(sine, w) / sine) * v : V<Quad>{};
}

// Symmetric 6×6 matrix 1 + Σ Jᵀ H J.
template <class T>
struct Matrix6 {
  T m[6][6] = {};

  // Adds H at a foot with β = b/ρ: J = (1, −β×).
  void add(const Stiffness<T>& H, const V<T>& beta) {
    const V<T> rows[3] = {{H.xx, H.xy, H.xz}, {H.xy, H.yy, H.yz}, {H.xz, H.yz, H.zz}};
    T left[3][3];  // β× H
    for (int j = 0; j < 3; ++j) {
      const V<T> column = cross(beta, rows[j]);
      left[0][j] = column.x, left[1][j] = column.y, left[2][j] = column.z;
    }
    for (int i = 0; i < 3; ++i) {
      const V<T> right = cross(beta, V<T>{left[i][0], left[i][1], left[i][2]});
      const T turned[3] = {right.x, right.y, right.z}, row[3] = {rows[i].x, rows[i].y, rows[i].z};
      for (int j = 0; j < 3; ++j) m[i][j] += row[j], m[3 + i][j] += left[i][j], m[3 + i][3 + j] += turned[j];
    }
  }
  // By LDLᵀ; the matrix is not below the identity.
  Six<T> solve(const Six<T>& b) const {
    T l[6][6] = {}, d[6];
    T y[6] = {b.way.x, b.way.y, b.way.z, b.arc.x, b.arc.y, b.arc.z};
    for (int j = 0; j < 6; ++j) {
      for (int i = j; i < 6; ++i) {
        T sum = m[i][j] + (i == j ? T(1) : T(0));
        for (int n = 0; n < j; ++n) sum -= l[i][n] * l[j][n] * d[n];
        if (i == j) d[j] = sum > T(1) ? sum : T(1);
        l[i][j] = i == j ? T(1) : sum / d[j];
      }
    }
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < i; ++j) y[i] -= l[i][j] * y[j];
    for (int i = 0; i < 6; ++i) y[i] /= d[i];
    for (int i = 5; i >= 0; --i)
      for (int j = i + 1; j < 6; ++j) y[i] -= l[j][i] * y[j];
    return {{y[0], y[1], y[2]}, {y[3], y[4], y[5]}};
  }
};

template <class T>
V<T> at_foot(const Six<T>& z, const V<T>& beta) {
  return z.way + cross(z.arc, beta);
}
template <class T>
Six<T> wrench(const V<T>& u, const V<T>& beta) {
  return {u, cross(beta, u)};
}
template <class T>
V<T> in(const V<Quad>& v) {
  return {static_cast<T>(v.x), static_cast<T>(v.y), static_cast<T>(v.z)};
}
template <class T>
V<T> beta_of(const PoseProblem& problem, std::size_t foot) {
  return (T(1) / T(problem.turning_radius_m)) * V<T>(problem.levers_m[foot]);
}

template <class T>
struct PoseState {
  std::vector<Item<T>> items;
  std::vector<V<T>> betas;  // by item
  Six<T> moved_m;           // from the start to the current pose; Z = 0 here
  Six<T> C;
  T k;

  PoseState(const PoseProblem& problem, const V<Quad>& rotation, const Six<T>& at_m)
      : moved_m(at_m), k(problem.stiffness_n_per_m) {
    const Six<T> wanted_m{V<T>(problem.probe.position_m) - V<T>(problem.start.position_m),
                          T(problem.turning_radius_m) * in<T>(rotation)};
    C = k * (wanted_m - moved_m);
    for (std::size_t i = 0; i < problem.primitives.size();) {
      const Primitive& p = problem.primitives[i];
      const V<T> beta = beta_of<T>(problem, p.id.foot);
      if (p.kind == PrimitiveKind::directed) {
        C = C + wrench(T(p.strength_n) * unit<T>(p), beta);
        ++i;
        continue;
      }
      const V<T> foot_m = V<T>(problem.step().foot_m(p.id.foot)) + at_foot(moved_m, beta);
      items.push_back(item_at<T>(problem.primitives, i, k, problem.time_step_s, foot_m));
      betas.push_back(beta);
      i += items.back().size();
    }
  }
  Newton<T, Six<T>> newton(T tau) const {
    Matrix6<T> M;
    Six<T> f = C;
    T size = length(C);
    for (std::size_t i = 0; i < items.size();) {
      const V<T>& beta = betas[i];
      Stiffness<T> H;
      V<T> u;
      // All of a foot at once.
      for (; i < items.size() && betas[i].x == beta.x && betas[i].y == beta.y && betas[i].z == beta.z; ++i) {
        const Answer<T> a = answer(items[i], V<T>{}, tau);
        u = u + on_proxy(items[i], a.u);
        size += items[i].s;
        add_stiffness(H, items[i], a);
      }
      f = f + wrench(u, beta);
      M.add(H, beta);
    }
    return {f, size, M.solve(f)};
  }
  Six<T> left_over(const Six<T>& dz, T tau) const {
    Six<T> f = C - dz;
    for (std::size_t i = 0; i < items.size(); ++i)
      f = f + wrench(on_proxy(items[i], answer(items[i], at_foot(dz, betas[i]), tau).u), betas[i]);
    return f;
  }
  void shift_by(const Six<T>& dz) {
    for (std::size_t i = 0; i < items.size(); ++i) shift(items[i], at_foot(dz, betas[i]));
    C = C - dz;
    moved_m = moved_m + (T(1) / k) * dz;
  }
};

// (ρ + √(ρ² + 4kε))/(2k) in the metric.
Quad bound_at(const PoseProblem& problem, const V<Quad>& rotation, const PoseState<Quad>& state) {
  const std::vector<Primitive>& primitives = problem.primitives;
  std::vector<V<Quad>> forces;
  std::size_t next = 0;
  while (forces.size() < primitives.size()) {
    if (primitives[forces.size()].kind == PrimitiveKind::directed) {
      forces.emplace_back();
    } else {
      append_forces(state.items[next++], forces);
    }
  }
  const Quad k = problem.stiffness_n_per_m;
  const Six<Quad> wanted_m{V<Quad>(problem.probe.position_m) - V<Quad>(problem.start.position_m),
                           Quad(problem.turning_radius_m) * rotation};
  Six<Quad> left = k * (state.moved_m - wanted_m);
  Quad gap = 0;
  for (std::size_t i = 0; i < primitives.size();) {
    const std::size_t size = size_of_whole(primitives, i);
    const V<Quad> beta = beta_of<Quad>(problem, primitives[i].id.foot);
    const V<Quad> foot_m = V<Quad>(problem.step().foot_m(primitives[i].id.foot)) + at_foot(state.moved_m, beta);
    gap += gap_of(std::span(primitives).subspan(i, size), foot_m, problem.time_step_s, std::span(forces).subspan(i, size));
    for (const std::size_t end = i + size; i < end; ++i) left = left - wrench(forces[i], beta);
  }
  const Quad squared = dot(left, left);
  return (root(squared) + root(squared + 4 * k * gap)) / (2 * k);
}

Six<Quad> in_quad(const Six<double>& a) { return {V<Quad>(a.way), V<Quad>(a.arc)}; }
Six<Quad> moved_m(const PoseReference& reference) {
  return {{reference.way_m[0], reference.way_m[1], reference.way_m[2]},
          {reference.arc_m[0], reference.arc_m[1], reference.arc_m[2]}};
}

}  // namespace
}  // namespace six

using namespace six;

PoseReference reference_pose(const PoseProblem& problem) {
  PoseReference best;
  best.bound_m = DBL_MAX;
  const V<Quad> rotation = rotation_between(problem.start.turn, problem.probe.turn);
  const auto prove = [&](const PoseState<Quad>& state) {
    const Quad bound = bound_at(problem, rotation, state);
    if (bound < best.bound_m) {
      best.bound_m = bound;
      const Six<Quad>& m = state.moved_m;
      best.way_m[0] = m.way.x, best.way_m[1] = m.way.y, best.way_m[2] = m.way.z;
      best.arc_m[0] = m.arc.x, best.arc_m[1] = m.arc.y, best.arc_m[2] = m.arc.z;
    }
    return best.bound_m;
  };

  PoseState<double> rough(problem, rotation, {});
  Six<double> moved;  // accumulates digits that double would lose
  for (double tau = 1e2; tau <= 1e10; tau *= 1e2) {
    rough.moved_m = {};
    minimise<PoseState<double>, double>(rough, tau, 1e-15, 40);
    moved = moved + rough.moved_m;
    for (Item<double>& item : rough.items) take_force<double>(item, tau);
  }
  if (finite(moved)) {
    PoseState<Quad> state(problem, rotation, in_quad(moved));
    for (std::size_t i = 0; i < state.items.size(); ++i) state.items[i].u = V<Quad>(rough.items[i].u);
    best.iterations += polish(state, 1e12, 1e6, Quad(certified_m) / 10, prove);
  }
  if (!(best.bound_m <= Quad(certified_m))) {
    PoseState<Quad> state(problem, rotation, {});
    best.iterations += polish(state, 1e3, 10.0, Quad(certified_m) / 10, prove);
  }
  best.certified = best.bound_m <= Quad(certified_m);
  return best;
}

double error_m(const PoseReference& reference, const PoseProblem& problem, const Balance& balance) {
  const Six<Quad> at_m{V<Quad>(balance.position_m) - V<Quad>(problem.start.position_m),
                       Quad(problem.turning_radius_m) * V<Quad>(balance.turn_rad)};
  return static_cast<double>(length(at_m - moved_m(reference)));
}

double foot_error_m(const PoseReference& reference, const PoseProblem& problem, std::size_t foot, const Vec3& position_m) {
  const V<Quad> foot_m = V<Quad>(problem.step().foot_m(foot)) + at_foot(moved_m(reference), beta_of<Quad>(problem, foot));
  return static_cast<double>(length(V<Quad>(position_m) - foot_m));
}

}  // namespace palpa::test
