// The augmented Lagrangian, for what the active set does not settle.
#include "palpa/solver/solver_work.h"

namespace palpa {

using namespace detail::solving;

// 3. Method of multipliers. For a penalty τ the convex, once differentiable
//     Ψ(Z) = ½|Z − C|² + Σ max_v [v·R − φ*(v) − |v − u|²/(2τ)],   ∇Ψ = Z − C − Σ answer(u + τR)
// is minimised; the forces `answer` there are the next u. From any forces this converges to balanced forces, the faster the
// greater τ. Once the states are clear, an active-set step yields the last digits sooner.
void Solver::Work::augmented_lagrangian() noexcept {
  // Failed steps can leave forces far beyond s where a drag is large: no good start.
  bool too_long = false;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    if (!(p.t > p.s)) continue;
    p.t = p.s, too_long = true;
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    if (p.gamma == 0.0 || !(norm_squared(p.u) > p.s * p.s)) continue;
    p.u = shortened(p.u, p.s), too_long = true;
  }
  if (too_long) Z_ = sum();
  double tau = first_penalty;
  for (int i = 0; i < max_penalties; ++i) {
    recentre();
    if (!minimise(tau) && tau <= unsteady_penalty) {
      tau = std::max(1.0, 1e-2 * tau);
      continue;
    }
    for (std::size_t j = 0; j < plane_count_; ++j) {
      Plane& p = planes_[j];
      p.t = answer(p, p.t + tau * p.residual(Z_), tau);
    }
    for (std::size_t j = 0; j < span_count_; ++j) {
      Span& p = spans_[j];
      p.u = p.across(answer(p, p.u + tau * p.residual(Z_), tau));
    }
    for (std::size_t j = 0; j < corner_count_; ++j) corners_[j].answer(corners_[j].pull(Z_, tau, corners_[j].face), tau);
    if (certify(3)) return;
    if (i == 0 || tau > steady_penalty) {
      recentre();
      keep();
      active_set_step();
      if (certify(3)) return;
      restore();
    }
    tau = std::min(largest_penalty, 10.0 * tau);
  }
}

// Newton's method for Ψ, to the precision that the forces of this τ need. Returns whether it converged.
bool Solver::Work::minimise(double tau) noexcept {
  for (int step = 0; step < max_newton_steps; ++step) {
    Stiffness M;
    Vec3 g = C_ - Z_;  // −∇Ψ
    double size = size_of(C_);
    for (std::size_t i = 0; i < plane_count_; ++i) {
      const Plane& p = planes_[i];
      const double w = p.t + tau * p.residual(Z_);
      const double t = answer(p, w, tau);
      g += t * p.q;
      size += t;
      const double yields = 1.0 + p.compliance * tau;
      if (w > 0.0) M.add(w <= p.s * yields ? tau / yields : tau * (p.gamma / (tau + p.gamma)), p.q);
    }
    for (std::size_t i = 0; i < span_count_; ++i) {
      const Span& p = spans_[i];
      const Vec3 w = p.u + tau * p.residual(Z_);
      const double squared = norm_squared(w);
      double across = tau;
      if (squared <= p.s * p.s) {
        g += w;
      } else {
        const double asked = std::sqrt(squared);
        const double share = length_given(asked, p.s, p.gamma, tau) / asked;
        g += share * w;
        across = tau * share;
        M.add(tau * (p.gamma / (tau + p.gamma)) - across, (1.0 / asked) * w);
      }
      size += size_of(p.u);
      M.add_everywhere(across);
      M.add(-across, p.q);
    }
    for (std::size_t i = 0; i < corner_count_; ++i) {
      const Corner& p = corners_[i];
      const detail::LeastWay way = p.pull(Z_, tau, p.face);
      const double squared = norm_squared(way.w);
      const double yields = 1.0 + p.compliance * tau;
      const bool slips = std::sqrt(squared) > p.s * yields;
      const double share = slips ? p.s / std::sqrt(squared) : 1.0 / yields;
      g += share * way.w;
      size += size_of(p.u);
      M.add(tau * share, way.face);
      if (slips) M.add(-tau * share, (1.0 / std::sqrt(squared)) * way.w);
    }
    ++iterations_;
    // Up to a share of all forces that falls with τ, but not below rounding. Less: steps whose gain the next penalty replaces;
    // more: the next forces are worse, and more penalties are needed.
    if (size_of(g) <= std::max(4.0 * epsilon, 1e-6 / tau) * size) return true;
    const Vec3 d = Factor(M).solve(g);
    const double slope_at_start = -dot(g, d);
    if (!(slope_at_start < 0.0) || !is_finite(d)) return true;
    const double share = search(d, slope_at_start, tau);
    if (!(share > 0.0)) return true;
    Z_ += share * d;
  }
  return false;
}

// Step length along d, where Ψ is convex: its slope, negative at 0, only grows. The full step if that is not past the minimum;
// otherwise the minimum is bracketed, and a share is taken at which Ψ has surely fallen: before the minimum with half the slope
// gone, or past it by less than was gained before. 0 if rounding leaves no gain.
double Solver::Work::search(const Vec3& d, double slope_at_start, double tau) const noexcept {
  double low = 0.0, at_low = slope_at_start;
  double high = 1.0, at_high = slope(Z_ + d, d, tau);
  if (at_high <= 0.0) return high;
  for (int i = 0; i < max_search_steps; ++i) {
    const double secant = low + (high - low) * (at_low / (at_low - at_high));
    // The secant, at least a tenth from `low` and four tenths from `high`, so that it cannot creep where the slope has kinks.
    // Narrower limits: slower where Ψ is smooth; wider: it may creep.
    const double share = std::clamp(secant, low + 0.1 * (high - low), low + 0.6 * (high - low));
    const double at_share = slope(Z_ + share * d, d, tau);
    (at_share <= 0.0 ? low : high) = share;
    (at_share <= 0.0 ? at_low : at_high) = at_share;
    if (at_high * (high - low) <= -0.5 * at_low * low) return high;
    if (low > 0.0 && at_low >= 0.5 * slope_at_start) return low;
  }
  return low;
}

// d·∇Ψ.
double Solver::Work::slope(const Vec3& at, const Vec3& d, double tau) const noexcept {
  double slope = dot(at - C_, d);
  for (std::size_t i = 0; i < plane_count_; ++i) {
    const Plane& p = planes_[i];
    slope -= answer(p, p.t + tau * p.residual(at), tau) * dot(p.q, d);
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    const Span& p = spans_[i];
    slope -= dot(answer(p, p.u + tau * p.residual(at), tau), d);
  }
  for (std::size_t i = 0; i < corner_count_; ++i) {
    const Corner& p = corners_[i];
    slope -= dot(shortened(p.pull(at, tau, p.face).w / (1.0 + p.compliance * tau), p.s), d);
  }
  return slope;
}

}  // namespace palpa
