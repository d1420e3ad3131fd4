// A plain interior-point method for conic problems, to compare the exact law with: what one would otherwise write.
#pragma once

#include <vector>

#include "tests/solver/random_problems.h"

namespace palpa::bench {

/// Minimises ½ x'Px + q'x subject to h − Gx in K, K = half-lines, then second-order cones, with dense matrices:
/// primal-dual, Nesterov–Todd scaling, Mehrotra's predictor and corrector, as in Vandenberghe, The CVXOPT linear
/// and quadratic cone program solvers (2010). It knows nothing of the balance; `balance_m` poses one to it as a
/// general solver has to be asked. Memory is taken once, for the largest problem; nothing allocates after that.
class InteriorPoint {
 public:
  /// Room for problems of up to `primitives` primitives.
  explicit InteriorPoint(int primitives);

  struct Answer {
    Vec3 position_m;
    int iterations = 0;
    bool converged = false;  ///< gap and residuals at most 1e-8 of the problem's scale
  };

  /// The balance in epigraph form: x, and for each primitive a length t_i >= |r_i(x)| that costs s t + c/(2T) t².
  /// In units of the largest force, lengths of force/k.
  Answer balance_m(const test::Problem& problem);

 private:
  struct Cone {
    int first = 0;  ///< row
    int rows = 0;   ///< 1: a half-line
  };

  void pose(const test::Problem& problem);
  int solve();

  void start();
  bool factorise();
  void solve_factorised(std::vector<double>& x) const;
  void scale(const std::vector<double>& v, std::vector<double>& out) const;       // W v
  void scale_back(const std::vector<double>& v, std::vector<double>& out) const;  // W⁻¹ v
  void scaled_columns();                                                          // W⁻¹ G
  void newton_step(const std::vector<double>& centring);                          // dx, ds, dz, scaled too
  double largest_step(const std::vector<double>& scaled_direction) const;
  void update_scaling();

  int variables_ = 0;
  int rows_ = 0;
  std::vector<Cone> cones_;
  double force_n_ = 1.0;
  bool converged_ = false;

  // The problem: G and P by rows; P is diagonal.
  std::vector<double> P_, q_, G_, h_;
  // The iterate, residuals, direction, and the scaling: W = eta [w0 w1'; w1 I + w1 w1'/(1 + w0)] for each cone.
  std::vector<double> x_, s_, z_, lambda_, rx_, rz_, dx_, ds_, dz_, scaled_ds_, scaled_dz_;
  std::vector<double> w_, eta_;
  std::vector<double> scaled_G_, N_, centring_, by_lambda_, row_work_, x_work_;
};

}  // namespace palpa::bench
