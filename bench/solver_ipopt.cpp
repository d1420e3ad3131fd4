#include "solver_ipopt.h"

#include <IpStdCInterface.h>

#include <cassert>
#include <cmath>
#include <vector>

namespace palpa::bench {

namespace {

/// One primitive's force: how many coordinates, where they are, and its set.
struct Force {
  int first = 0;  ///< among the variables
  int size = 0;   ///< 1: 0 <= t <= s; 2 or 3: |u| <= s
  Vec3 axes[3];
  Vec3 anchor;  ///< [1] in units of force
  double strength = 0.0;
};

struct Dual {
  std::vector<Force> forces;
  Vec3 C;
  double force_n = 1.0;
  int variables = 3;  // Z first
  int balls = 0;
};

Dual dual_of(const test::Problem& problem) {
  Dual dual;
  const double k = problem.stiffness_n_per_m;
  dual.C = k * (problem.probe_m - problem.start_m);
  dual.force_n = 1e-9;
  for (const Primitive& p : problem.primitives) {
    assert(p.drag_ns_per_m == 0.0);
    if (p.kind == PrimitiveKind::directed) dual.C += p.strength_n * p.direction;
    dual.force_n = std::max(dual.force_n, p.strength_n);
  }
  dual.force_n = std::max(dual.force_n, norm(dual.C));
  dual.C = dual.C / dual.force_n;
  for (const Primitive& p : problem.primitives) {
    if (p.kind == PrimitiveKind::directed || p.strength_n == 0.0) continue;
    const Vec3 e = normalized(cross(p.direction, std::abs(p.direction.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    Force f{
        dual.variables, 1, {p.direction}, (k / dual.force_n) * (p.position_m - problem.start_m), p.strength_n / dual.force_n};
    if (p.kind == PrimitiveKind::point) f.size = 3, f.axes[0] = {1, 0, 0}, f.axes[1] = {0, 1, 0}, f.axes[2] = {0, 0, 1};
    if (p.kind == PrimitiveKind::line) f.size = 2, f.axes[0] = e, f.axes[1] = cross(p.direction, e);
    dual.variables += f.size;
    dual.balls += f.size > 1;
    dual.forces.push_back(f);
  }
  return dual;
}

const Dual& dual_in(UserDataPtr data) { return *static_cast<const Dual*>(data); }

Bool objective(Index, Number* v, Bool, Number* value, UserDataPtr data) {
  *value = 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  for (const Force& f : dual_in(data).forces) {
    for (int i = 0; i < f.size; ++i) *value -= dot(f.anchor, f.axes[i]) * v[f.first + i];
  }
  return TRUE;
}

Bool objective_gradient(Index, Number* v, Bool, Number* gradient, UserDataPtr data) {
  for (int i = 0; i < 3; ++i) gradient[i] = v[i];
  for (const Force& f : dual_in(data).forces) {
    for (int i = 0; i < f.size; ++i) gradient[f.first + i] = -dot(f.anchor, f.axes[i]);
  }
  return TRUE;
}

// Rows 0 to 2: Z − Σu = C; then |u|² of each ball.
Bool constraints(Index, Number* v, Bool, Index, Number* values, UserDataPtr data) {
  for (int i = 0; i < 3; ++i) values[i] = v[i];
  int row = 3;
  for (const Force& f : dual_in(data).forces) {
    double squared = 0.0;
    for (int i = 0; i < f.size; ++i) {
      const double u = v[f.first + i];
      values[0] -= u * f.axes[i].x, values[1] -= u * f.axes[i].y, values[2] -= u * f.axes[i].z;
      squared += u * u;
    }
    if (f.size > 1) values[row++] = squared;
  }
  return TRUE;
}

Bool jacobian(Index, Number* v, Bool, Index, Index, Index* rows, Index* columns, Number* values, UserDataPtr data) {
  int at = 0;
  const auto put = [&](int row, int column, double value) {
    if (values == nullptr) {
      rows[at] = row, columns[at] = column;
    } else {
      values[at] = value;
    }
    ++at;
  };
  for (int i = 0; i < 3; ++i) put(i, i, 1.0);
  int ball = 3;
  for (const Force& f : dual_in(data).forces) {
    for (int i = 0; i < f.size; ++i) {
      put(0, f.first + i, -f.axes[i].x);
      put(1, f.first + i, -f.axes[i].y);
      put(2, f.first + i, -f.axes[i].z);
      if (f.size > 1) put(ball, f.first + i, values == nullptr ? 0.0 : 2.0 * v[f.first + i]);
    }
    ball += f.size > 1;
  }
  return TRUE;
}

Bool hessian(Index, Number*, Bool, Number of_objective, Index, Number* multipliers, Bool, Index, Index* rows, Index* columns,
             Number* values, UserDataPtr data) {
  int at = 0;
  const auto put = [&](int i, double value) {
    if (values == nullptr) {
      rows[at] = columns[at] = i;
    } else {
      values[at] = value;
    }
    ++at;
  };
  for (int i = 0; i < 3; ++i) put(i, of_objective);
  int ball = 3;
  for (const Force& f : dual_in(data).forces) {
    if (f.size == 1) continue;
    for (int i = 0; i < f.size; ++i) put(f.first + i, values == nullptr ? 0.0 : 2.0 * multipliers[ball]);
    ++ball;
  }
  return TRUE;
}

}  // namespace

IpoptAnswer balance_by_ipopt(const test::Problem& problem, double tolerance) {
  Dual dual = dual_of(problem);
  const auto n = static_cast<std::size_t>(dual.variables);
  const auto m = static_cast<std::size_t>(3 + dual.balls);
  std::vector<Number> low(n, -2e19), high(n, 2e19), row_low(m, -2e19), row_high(m), v(n, 0.0);
  row_low[0] = row_high[0] = dual.C.x, row_low[1] = row_high[1] = dual.C.y, row_low[2] = row_high[2] = dual.C.z;
  v[0] = dual.C.x, v[1] = dual.C.y, v[2] = dual.C.z;
  Index jacobian_size = 3, hessian_size = 3, row = 3;
  for (const Force& f : dual.forces) {
    jacobian_size += 3 * f.size;
    if (f.size == 1) {
      low[static_cast<std::size_t>(f.first)] = 0.0, high[static_cast<std::size_t>(f.first)] = f.strength;
    } else {
      jacobian_size += f.size, hessian_size += f.size;
      row_high[static_cast<std::size_t>(row++)] = f.strength * f.strength;
    }
  }
  IpoptProblem ipopt =
      CreateIpoptProblem(dual.variables, low.data(), high.data(), static_cast<Index>(m), row_low.data(), row_high.data(),
                         jacobian_size, hessian_size, 0, objective, constraints, objective_gradient, jacobian, hessian);
  char print_level[] = "print_level", banner[] = "sb", yes[] = "yes", tol[] = "tol", strategy[] = "mu_strategy",
       adaptive[] = "adaptive";
  AddIpoptIntOption(ipopt, print_level, 0);
  AddIpoptStrOption(ipopt, banner, yes);
  AddIpoptStrOption(ipopt, strategy, adaptive);
  AddIpoptNumOption(ipopt, tol, tolerance);
  const ApplicationReturnStatus status = IpoptSolve(ipopt, v.data(), nullptr, nullptr, nullptr, nullptr, nullptr, &dual);
  FreeIpoptProblem(ipopt);
  // Z = k (x − start)
  return {problem.start_m + (dual.force_n / problem.stiffness_n_per_m) * Vec3{v[0], v[1], v[2]},
          status == Solve_Succeeded || status == Solved_To_Acceptable_Level};
}

}  // namespace palpa::bench
