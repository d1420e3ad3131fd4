// Last stage of a tool's balance: multipliers, as those of the point (multipliers.cpp) with J Z in place of Z.
#include "palpa/solver/pose_work.h"

namespace palpa {

using namespace detail::solving;
using namespace detail::posing;

namespace {
// [1] First penalties of the multipliers, from zero forces and from those of the balance before, and the ratio of successive
// ones. Lower: more penalties; higher: Newton's method may fail from afar.
constexpr double cold_penalty = 1e3, warm_penalty = 1e3;
constexpr double next_penalty = 100.0;
}  // namespace

// Sets the next forces of the multipliers.
void PoseSolver::Work::answer_all(double tau) noexcept {
  look();
  for (std::size_t i = 0; i < planes_; ++i) {
    AtFoot<Plane>& p = plane_[i];
    p.t = answer(p, p.t + tau * p.residual(feet_[p.foot].Z), tau);
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    FootSpan& p = span_[i];
    p.u = p.across(answer(p, p.u + tau * p.residual(feet_[p.foot].Z), tau));
  }
  for (std::size_t i = 0; i < corners_; ++i) {
    AtFoot<Corner>& p = corner_[i];
    p.answer(p.pull(feet_[p.foot].Z, tau), tau);
  }
}

bool PoseSolver::Work::augmented_lagrangian() noexcept {
  // Failed steps can leave forces far beyond s where a drag is large: no good start.
  for (std::size_t i = 0; i < planes_; ++i) plane_[i].t = std::min(plane_[i].t, plane_[i].s);
  for (std::size_t i = 0; i < spans_; ++i) span_[i].u = shortened(span_[i].u, span_[i].s);
  Z_ = sum();
  double tau = warm_ ? warm_penalty : cold_penalty;
  for (int i = 0; i < max_penalties && any_left(); ++i) {
    if (i > 0) recentre();
    if (!minimise(tau) && tau <= unsteady_penalty) {
      tau = std::max(1.0, 1e-2 * tau);
      continue;
    }
    answer_all(tau);
    if (certify(3)) return true;
    if (i == 0 || tau > steady_penalty) {
      if (is_recentring_shown()) recentre();
      keep();
      active_set_step();
      if (certify(3)) return true;
      restore();
    }
    tau = std::min(largest_penalty, next_penalty * tau);
  }
  return false;
}

// Sets the forces and the stiffness of all feet for this τ; returns the size of the forces.
double PoseSolver::Work::pull(double tau) noexcept {
  for (std::size_t f = 0; f < feet_count_; ++f) feet_[f].u = {}, feet_[f].K = Foot::none, feet_[f].is_stiff = false;
  double size = 0.0;
  for (std::size_t i = 0; i < planes_; ++i) {
    const AtFoot<Plane>& p = plane_[i];
    Foot& foot = feet_[p.foot];
    const double w = p.t + tau * p.residual(foot.Z);
    const double yields = 1.0 + p.compliance * tau, drag = p.gamma / (tau + p.gamma);
    plane_rays_[i] = {w / yields, 0.0, p.s, drag, yields};
    if (!(w > 0.0)) continue;
    const double t = answer(p, w, tau);
    foot.u += t * p.q;
    size += t;
    const double along = w <= p.s * yields ? tau / yields : tau * drag;
    if (along > 0.0) foot.stiffen(along, p.q);
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    const FootSpan& p = span_[i];
    Foot& foot = feet_[p.foot];
    const Vec3 w = p.u + tau * p.residual(foot.Z);
    const double squared = norm_squared(w), drag = p.gamma / (tau + p.gamma);
    span_rays_[i] = {w, {}, p.s, drag};
    double across = tau;
    if (squared <= p.s * p.s) {
      foot.u += w;
    } else {
      const double asked = std::sqrt(squared);
      const double share = length_given(asked, p.s, p.gamma, tau) / asked;
      foot.u += share * w;
      across = tau * share;
      foot.K.add(tau * drag - across, (1.0 / asked) * w);
    }
    size += size_of(p.u);
    foot.K.add_everywhere(across);
    foot.K.add(-across, p.q);
    foot.is_stiff = true;
  }
  return size + pull_corners(tau);
}

double PoseSolver::Work::pull_corners(double tau) noexcept {
  double size = 0.0;
  for (std::size_t i = 0; i < corners_; ++i) {
    const AtFoot<Corner>& p = corner_[i];
    Foot& foot = feet_[p.foot];
    const detail::LeastWay way = p.pull(foot.Z, tau);
    const double asked = std::sqrt(norm_squared(way.w));
    const double yields = 1.0 + p.compliance * tau;
    const bool slips = asked > p.s * yields;
    const double share = slips ? p.s / asked : 1.0 / yields;
    foot.u += share * way.w;
    size += size_of(p.u);
    foot.K.add(tau * share, way.face);
    foot.is_stiff = true;
    if (slips) foot.K.add(-tau * share, (1.0 / asked) * way.w);
  }
  return size;
}

// Newton's method for Ψ, to the precision that the forces of this τ need. Returns whether it converged.
bool PoseSolver::Work::minimise(double tau) noexcept {
  for (int step = 0; step < max_newton_steps && any_left(); ++step) {
    look();
    const double size = size_of(C_) + pull(tau);
    Six g = C_ - Z_;  // −∇Ψ
    Factor6 M;
    for (std::size_t f = 0; f < feet_count_; ++f) {
      g += wrench(feet_[f].u, feet_[f].beta);
      if (feet_[f].is_stiff) M.add(feet_[f].K, feet_[f].beta);
    }
    count();
    if (size_of(g) <= std::max(4.0 * epsilon, 1e-6 / tau) * size) return true;
    M.factor();
    const Six d = M.solve(g);
    const double slope_at_start = -dot(g, d);
    if (!(slope_at_start < 0.0) || !is_finite(d)) return true;
    const double share = search(d, slope_at_start, tau);
    if (!(share > 0.0)) return true;
    Z_ += share * d;
  }
  return false;
}

// Step length along d: see Solver::Work::search.
double PoseSolver::Work::search(const Six& d, double slope_at_start, double tau) noexcept {
  cast(d, tau);
  double low = 0.0, at_low = slope_at_start;
  double high = 1.0, at_high = slope(high, d, tau);
  if (at_high <= 0.0) return high;
  for (int i = 0; i < max_search_steps && any_left(); ++i) {
    const double secant = low + (high - low) * (at_low / (at_low - at_high));
    const double share = std::clamp(secant, low + 0.1 * (high - low), low + 0.6 * (high - low));
    const double at_share = slope(share, d, tau);
    (at_share <= 0.0 ? low : high) = share;
    (at_share <= 0.0 ? at_low : at_high) = at_share;
    if (at_high * (high - low) <= -0.5 * at_low * low) return high;
    if (low > 0.0 && at_low >= 0.5 * slope_at_start) return low;
  }
  return low;
}

// Sets the pulls of planes and spans along Z + share d: they are linear in the share. Their start is of `pull`.
void PoseSolver::Work::cast(const Six& d, double tau) noexcept {
  for (std::size_t f = 0; f < feet_count_; ++f) feet_[f].u = at_foot(d, feet_[f].beta);
  for (std::size_t i = 0; i < planes_; ++i)
    plane_rays_[i].change = -tau / plane_rays_[i].yields * dot(plane_[i].q, feet_[plane_[i].foot].u);
  for (std::size_t i = 0; i < spans_; ++i) span_rays_[i].change = span_[i].across(-tau * feet_[span_[i].foot].u);
}

// d·∇Ψ at Z + share d.
double PoseSolver::Work::slope(double share, const Six& d, double tau) noexcept {
  double pulled = 0.0;  // times τ
  for (std::size_t i = 0; i < planes_; ++i) {
    const PlaneRay& ray = plane_rays_[i];
    const double w = ray.start + share * ray.change;
    if (w > 0.0) pulled += (w <= ray.s ? w : ray.s + ray.drag * (w - ray.s)) * (ray.yields * ray.change);
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    const SpanRay& ray = span_rays_[i];
    const Vec3 w = ray.start + share * ray.change;
    const double squared = norm_squared(w), along = dot(w, ray.change);
    if (squared <= ray.s * ray.s) {
      pulled += along;
    } else {
      const double asked = std::sqrt(squared);
      pulled += (ray.s + ray.drag * (asked - ray.s)) / asked * along;
    }
  }
  double slope = dot(Z_ - C_, d) + share * dot(d, d) + pulled / tau;
  const Six at = Z_ + share * d;
  for (std::size_t i = 0; i < corners_; ++i) {
    const AtFoot<Corner>& p = corner_[i];
    const Foot& foot = feet_[p.foot];
    const Vec3 w = p.pull(at_foot(at, foot.beta), tau).w;
    slope -= dot(shortened(w / (1.0 + p.compliance * tau), p.s), foot.u);
  }
  rows_ += static_cast<int>(size());
  return slope;
}

}  // namespace palpa
