#include "interior_point.h"

#include <algorithm>
#include <cmath>

namespace palpa::bench {

namespace {

constexpr double tolerance = 1e-8;
constexpr int most_iterations = 60;

double product(const double* a, const double* b, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// Two unit vectors across `q`.
struct Across {
  explicit Across(const Vec3& q) {
    first = normalized(cross(q, std::abs(q.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    second = cross(q, first);
  }
  Vec3 first, second;
};

bool in_epigraph(const Primitive& p) {
  return p.kind != PrimitiveKind::directed && (p.strength_n > 0.0 || p.drag_ns_per_m > 0.0);
}

}  // namespace

InteriorPoint::InteriorPoint(int primitives) {
  const std::size_t n = static_cast<std::size_t>(primitives) + 3, m = 4 * static_cast<std::size_t>(primitives);
  cones_.reserve(2 * static_cast<std::size_t>(primitives));
  for (auto* v : {&P_, &q_, &x_, &rx_, &dx_, &x_work_}) v->resize(n);
  for (auto* v :
       {&h_, &s_, &z_, &lambda_, &rz_, &ds_, &dz_, &scaled_ds_, &scaled_dz_, &w_, &centring_, &by_lambda_, &row_work_, &eta_}) {
    v->resize(m);
  }
  G_.resize(m * n);
  scaled_G_.resize(m * n);
  N_.resize(n * n);
}

void InteriorPoint::pose(const test::Problem& problem) {
  const double k = problem.stiffness_n_per_m;
  Vec3 C = k * (problem.probe_m - problem.start_m);
  force_n_ = 0.0;
  variables_ = 3;
  for (const Primitive& p : problem.primitives) {
    if (p.kind == PrimitiveKind::directed) C += p.strength_n * p.direction;
    if (!in_epigraph(p)) continue;
    ++variables_;
    force_n_ = std::max(force_n_, p.strength_n);
  }
  force_n_ = std::max({force_n_, norm(C), 1e-9});
  C = C / force_n_;

  const int n = variables_;
  rows_ = 0;
  cones_.clear();
  std::fill_n(P_.begin(), n, 0.0);
  std::fill_n(P_.begin(), 3, 1.0);
  q_[0] = -C.x, q_[1] = -C.y, q_[2] = -C.z;
  const auto add_row = [&](const Vec3& along_x, int t, double of_t, double right) {
    double* row = &G_[static_cast<std::size_t>(rows_) * static_cast<std::size_t>(n)];
    std::fill_n(row, n, 0.0);
    row[0] = along_x.x, row[1] = along_x.y, row[2] = along_x.z;
    row[t] = of_t;
    h_[static_cast<std::size_t>(rows_++)] = right;
  };
  int t = 3;
  for (const Primitive& p : problem.primitives) {  // half-lines first: q·(a − x) <= t, 0 <= t
    if (!in_epigraph(p)) continue;
    const double anchored = dot(p.direction, (k / force_n_) * (p.position_m - problem.start_m));
    q_[static_cast<std::size_t>(t)] = p.strength_n / force_n_;
    P_[static_cast<std::size_t>(t)] = p.drag_ns_per_m > 0.0 ? p.drag_ns_per_m / (problem.time_step_s * k) : 0.0;
    if (p.kind == PrimitiveKind::plane) {
      cones_.push_back({rows_, 1});
      add_row(-p.direction, t, -1.0, -anchored);
      cones_.push_back({rows_, 1});
      add_row({}, t, -1.0, 0.0);
    }
    ++t;
  }
  t = 3;
  for (const Primitive& p : problem.primitives) {  // then cones: |r(x)| <= t
    if (!in_epigraph(p)) continue;
    if (p.kind != PrimitiveKind::plane) {
      const Vec3 a = (k / force_n_) * (p.position_m - problem.start_m);
      const bool line = p.kind == PrimitiveKind::line;
      const Across across(p.direction);
      const Vec3 axes[3] = {line ? across.first : Vec3{1, 0, 0}, line ? across.second : Vec3{0, 1, 0}, {0, 0, 1}};
      cones_.push_back({rows_, line ? 3 : 4});
      add_row({}, t, -1.0, 0.0);
      for (int i = 0; i < (line ? 2 : 3); ++i) add_row(axes[i], t, 0.0, dot(axes[i], a));
    }
    ++t;
  }
}

void InteriorPoint::scale(const std::vector<double>& v, std::vector<double>& out) const {
  for (std::size_t c = 0; c < cones_.size(); ++c) {
    const int f = cones_[c].first, rows = cones_[c].rows;
    if (rows == 1) {
      out[f] = eta_[c] * v[f];
      continue;
    }
    const double along = product(&w_[f + 1], &v[f + 1], rows - 1);
    const double v0 = v[f], share = v0 + along / (1.0 + w_[f]);
    out[f] = eta_[c] * (w_[f] * v0 + along);
    for (int i = 1; i < rows; ++i) out[f + i] = eta_[c] * (v[f + i] + share * w_[f + i]);
  }
}

void InteriorPoint::scale_back(const std::vector<double>& v, std::vector<double>& out) const {
  for (std::size_t c = 0; c < cones_.size(); ++c) {
    const int f = cones_[c].first, rows = cones_[c].rows;
    if (rows == 1) {
      out[f] = v[f] / eta_[c];
      continue;
    }
    const double along = product(&w_[f + 1], &v[f + 1], rows - 1);
    const double v0 = v[f], share = -v0 + along / (1.0 + w_[f]);
    out[f] = (w_[f] * v0 - along) / eta_[c];
    for (int i = 1; i < rows; ++i) out[f + i] = (v[f + i] + share * w_[f + i]) / eta_[c];
  }
}

void InteriorPoint::scaled_columns() {
  const int n = variables_;
  for (std::size_t c = 0; c < cones_.size(); ++c) {
    const int f = cones_[c].first, rows = cones_[c].rows;
    const double* g = &G_[static_cast<std::size_t>(f) * n];
    double* out = &scaled_G_[static_cast<std::size_t>(f) * n];
    if (rows == 1) {
      for (int j = 0; j < n; ++j) out[j] = g[j] / eta_[c];
      continue;
    }
    for (int j = 0; j < n; ++j) {
      double along = 0.0;
      for (int i = 1; i < rows; ++i) along += w_[f + i] * g[i * n + j];
      const double share = -g[j] + along / (1.0 + w_[f]);
      out[j] = (w_[f] * g[j] - along) / eta_[c];
      for (int i = 1; i < rows; ++i) out[i * n + j] = (g[i * n + j] + share * w_[f + i]) / eta_[c];
    }
  }
}

// N = P + G' W⁻² G, Cholesky in place (lower triangle, by rows).
bool InteriorPoint::factorise() {
  const int n = variables_;
  scaled_columns();
  std::fill_n(N_.begin(), n * n, 0.0);
  for (int r = 0; r < rows_; ++r) {
    const double* g = &scaled_G_[static_cast<std::size_t>(r) * n];
    for (int i = 0; i < n; ++i) {
      if (g[i] == 0.0) continue;
      double* row = &N_[static_cast<std::size_t>(i) * n];
      for (int j = 0; j <= i; ++j) row[j] += g[i] * g[j];
    }
  }
  for (int i = 0; i < n; ++i) {
    double* row = &N_[static_cast<std::size_t>(i) * n];
    row[i] += P_[i];
    for (int j = 0; j < i; ++j) {
      const double* other = &N_[static_cast<std::size_t>(j) * n];
      row[j] = (row[j] - product(row, other, j)) / other[j];
    }
    const double pivot = row[i] - product(row, row, i);
    if (!(pivot > 0.0)) return false;
    row[i] = std::sqrt(pivot);
  }
  return true;
}

void InteriorPoint::solve_factorised(std::vector<double>& x) const {
  const int n = variables_;
  for (int i = 0; i < n; ++i) {
    const double* row = &N_[static_cast<std::size_t>(i) * n];
    x[i] = (x[i] - product(row, x.data(), i)) / row[i];
  }
  for (int i = n - 1; i >= 0; --i) {
    const double* row = &N_[static_cast<std::size_t>(i) * n];
    x[i] /= row[i];
    for (int j = 0; j < i; ++j) x[j] -= row[j] * x[i];
  }
}

// The minimiser of the problem with |h − Gx|² added, moved into the cones.
void InteriorPoint::start() {
  const int n = variables_;
  std::fill_n(eta_.begin(), cones_.size(), 1.0);
  std::fill_n(w_.begin(), rows_, 0.0);
  for (const Cone& cone : cones_) w_[cone.first] = 1.0;
  factorise();
  for (int j = 0; j < n; ++j) x_[j] = -q_[j];
  for (int r = 0; r < rows_; ++r) {
    for (int j = 0; j < n; ++j) x_[j] += G_[static_cast<std::size_t>(r) * n + j] * h_[r];
  }
  solve_factorised(x_);
  for (int r = 0; r < rows_; ++r) {
    s_[r] = h_[r] - product(&G_[static_cast<std::size_t>(r) * n], x_.data(), n);
    z_[r] = -s_[r];
  }
  for (auto* v : {&s_, &z_}) {
    double outside = -1e300;
    for (const Cone& cone : cones_) {
      const double* a = &(*v)[cone.first];
      outside = std::max(outside, std::sqrt(product(a + 1, a + 1, cone.rows - 1)) - a[0]);
    }
    if (outside < -1e-8) continue;
    for (const Cone& cone : cones_) (*v)[cone.first] += 1.0 + outside;
  }
}

void InteriorPoint::update_scaling() {
  for (std::size_t c = 0; c < cones_.size(); ++c) {
    const int f = cones_[c].first, rows = cones_[c].rows;
    if (rows == 1) {
      eta_[c] = std::sqrt(s_[f] / z_[f]);
      continue;
    }
    const auto length = [&](const std::vector<double>& v) {
      const double tail = std::sqrt(product(&v[f + 1], &v[f + 1], rows - 1));
      return std::sqrt(std::max((v[f] - tail) * (v[f] + tail), 1e-300));
    };
    const double s_length = length(s_), z_length = length(z_);
    double both = 0.0;
    for (int i = 0; i < rows; ++i) both += s_[f + i] * z_[f + i];
    const double gamma = std::sqrt(0.5 * (1.0 + both / (s_length * z_length)));
    eta_[c] = std::sqrt(s_length / z_length);
    for (int i = 0; i < rows; ++i) {
      w_[f + i] = (s_[f + i] / s_length + (i == 0 ? 1.0 : -1.0) * z_[f + i] / z_length) / (2.0 * gamma);
    }
    w_[f] = std::sqrt(1.0 + product(&w_[f + 1], &w_[f + 1], rows - 1));
  }
  scale(z_, lambda_);
}

// Solves P dx + G'dz = −rx, G dx + ds = −rz, λ∘(W dz + W⁻¹ ds) = −centring.
void InteriorPoint::newton_step(const std::vector<double>& centring) {
  const int n = variables_;
  for (const Cone& cone : cones_) {  // by_lambda = λ \ centring
    const int f = cone.first, rows = cone.rows;
    if (rows == 1) {
      by_lambda_[f] = centring[f] / lambda_[f];
      continue;
    }
    const double l0 = lambda_[f];
    const double tail = std::sqrt(product(&lambda_[f + 1], &lambda_[f + 1], rows - 1));
    const double det = (l0 - tail) * (l0 + tail);
    const double along = product(&lambda_[f + 1], &centring[f + 1], rows - 1);
    by_lambda_[f] = (l0 * centring[f] - along) / det;
    for (int i = 1; i < rows; ++i) by_lambda_[f + i] = (centring[f + i] - lambda_[f + i] * by_lambda_[f]) / l0;
  }
  // (P + G'W⁻²G) dx = −rx − G'W⁻¹(W⁻¹ rz − by_lambda)
  scale_back(rz_, row_work_);
  for (int r = 0; r < rows_; ++r) row_work_[r] -= by_lambda_[r];
  for (int j = 0; j < n; ++j) dx_[j] = -rx_[j];
  for (int r = 0; r < rows_; ++r) {
    const double* g = &scaled_G_[static_cast<std::size_t>(r) * n];
    for (int j = 0; j < n; ++j) dx_[j] -= g[j] * row_work_[r];
  }
  solve_factorised(dx_);
  for (int r = 0; r < rows_; ++r) {
    scaled_dz_[r] = row_work_[r] + product(&scaled_G_[static_cast<std::size_t>(r) * n], dx_.data(), n);
    scaled_ds_[r] = -by_lambda_[r] - scaled_dz_[r];
  }
}

double InteriorPoint::largest_step(const std::vector<double>& d) const {
  double inverse = 0.0;
  for (const Cone& cone : cones_) {
    const int f = cone.first, rows = cone.rows;
    if (rows == 1) {
      inverse = std::max(inverse, -d[f] / lambda_[f]);
      continue;
    }
    const double tail = std::sqrt(product(&lambda_[f + 1], &lambda_[f + 1], rows - 1));
    const double length = std::sqrt((lambda_[f] - tail) * (lambda_[f] + tail));
    const double l0 = lambda_[f] / length;
    const double along = product(&lambda_[f + 1], &d[f + 1], rows - 1) / length;
    const double rho0 = (l0 * d[f] - along) / length;
    double squared = 0.0;
    for (int i = 1; i < rows; ++i) {
      const double rho = d[f + i] / length - (rho0 + d[f] / length) / (l0 + 1.0) * lambda_[f + i] / length;
      squared += rho * rho;
    }
    inverse = std::max(inverse, std::sqrt(squared) - rho0);
  }
  return inverse > 0.0 ? 1.0 / inverse : 1e300;
}

int InteriorPoint::solve() {
  const int n = variables_;
  converged_ = false;
  start();
  int iteration = 0;
  for (; iteration < most_iterations; ++iteration) {
    double objective = 0.0, rx_largest = 0.0, rz_largest = 0.0;
    for (int j = 0; j < n; ++j) {
      rx_[j] = P_[j] * x_[j] + q_[j];
      objective += 0.5 * P_[j] * x_[j] * x_[j] + q_[j] * x_[j];
    }
    for (int r = 0; r < rows_; ++r) {
      const double* g = &G_[static_cast<std::size_t>(r) * n];
      rz_[r] = product(g, x_.data(), n) + s_[r] - h_[r];
      rz_largest = std::max(rz_largest, std::abs(rz_[r]));
      for (int j = 0; j < n; ++j) rx_[j] += g[j] * z_[r];
    }
    for (int j = 0; j < n; ++j) rx_largest = std::max(rx_largest, std::abs(rx_[j]));
    const double gap = product(s_.data(), z_.data(), rows_);
    converged_ = gap <= tolerance * std::max(std::abs(objective), 1e-3) && rx_largest <= tolerance && rz_largest <= tolerance;
    if (converged_) break;

    update_scaling();
    if (!factorise()) break;
    // Predictor: straight at the optimum.
    for (const Cone& cone : cones_) {
      const int f = cone.first;
      centring_[f] = product(&lambda_[f], &lambda_[f], cone.rows);
      for (int i = 1; i < cone.rows; ++i) centring_[f + i] = 2.0 * lambda_[f] * lambda_[f + i];
    }
    newton_step(centring_);
    const double predicted = std::min({1.0, largest_step(scaled_ds_), largest_step(scaled_dz_)});
    const double sigma = (1.0 - predicted) * (1.0 - predicted) * (1.0 - predicted);
    const double mu = gap / static_cast<double>(cones_.size());
    // Corrector: towards the centre as far as the predictor was cut short, and its second order.
    for (const Cone& cone : cones_) {
      const int f = cone.first;
      centring_[f] += product(&scaled_ds_[f], &scaled_dz_[f], cone.rows) - sigma * mu;
      for (int i = 1; i < cone.rows; ++i) {
        centring_[f + i] += scaled_ds_[f] * scaled_dz_[f + i] + scaled_dz_[f] * scaled_ds_[f + i];
      }
    }
    newton_step(centring_);
    const double step = std::min(1.0, 0.99 * std::min(largest_step(scaled_ds_), largest_step(scaled_dz_)));
    scale(scaled_ds_, ds_);
    scale_back(scaled_dz_, dz_);
    for (int j = 0; j < n; ++j) x_[j] += step * dx_[j];
    for (int r = 0; r < rows_; ++r) {
      s_[r] += step * ds_[r];
      z_[r] += step * dz_[r];
    }
  }
  return iteration;
}

InteriorPoint::Answer InteriorPoint::balance_m(const test::Problem& problem) {
  pose(problem);
  Answer answer;
  answer.iterations = solve();
  answer.converged = converged_;
  answer.position_m = problem.start_m + (force_n_ / problem.stiffness_n_per_m) * Vec3{x_[0], x_[1], x_[2]};
  return answer;
}

}  // namespace palpa::bench
