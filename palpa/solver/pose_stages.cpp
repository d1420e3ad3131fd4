// Stages of a tool's balance: sweep, active set, multipliers. Each is that of the point (closed_forms.cpp, active_set.cpp,
// multipliers.cpp) with J Z in place of Z; in its pull w = u + R/A the compliance A of the coupling at the foot is that along
// the primitive, 1 + |β × q|², or at most 1 + |β|².
#include "palpa/solver/pose_work.h"

namespace palpa {

using namespace detail::solving;
using namespace detail::posing;

namespace {
// [1] First penalties of the multipliers, from zero forces and from those of the balance before, and the ratio of successive
// ones. Lower: more penalties; higher: Newton's method may fail from afar.
constexpr double cold_penalty = 1e4, warm_penalty = 1e6;
constexpr double next_penalty = 100.0;
}  // namespace

void Factor6::add(const Stiffness& K, const Vec3& beta) noexcept {
  const Vec3 row[3] = {{K.xx, K.xy, K.xz}, {K.xy, K.yy, K.yz}, {K.xz, K.yz, K.zz}};
  const double k[3][3] = {{K.xx, K.xy, K.xz}, {K.xy, K.yy, K.yz}, {K.xz, K.yz, K.zz}};
  // With B = β×, the lower left block is B K, whose columns are β × those of K; the lower right one (B K) Bᵀ.
  const Vec3 column[3] = {cross(beta, row[0]), cross(beta, row[1]), cross(beta, row[2])};
  const double bk[3][3] = {{column[0].x, column[1].x, column[2].x},
                           {column[0].y, column[1].y, column[2].y},
                           {column[0].z, column[1].z, column[2].z}};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 turned = cross(beta, Vec3{bk[i][0], bk[i][1], bk[i][2]});
    const double bkb[3] = {turned.x, turned.y, turned.z};
    for (std::size_t j = 0; j < 3; ++j) m_[3 + i][j] += bk[i][j];
    for (std::size_t j = 0; j <= i; ++j) m_[i][j] += k[i][j], m_[3 + i][3 + j] += bkb[j];
  }
}

void Factor6::factor() noexcept {
  for (std::size_t j = 0; j < 6; ++j) {
    double d = m_[j][j];
    std::array<double, 6> ld{};  // L D of row j
    for (std::size_t n = 0; n < j; ++n) {
      ld[n] = m_[j][n] / by_d_[n];
      d -= m_[j][n] * ld[n];
    }
    by_d_[j] = 1.0 / std::max(1.0, d);
    for (std::size_t i = j + 1; i < 6; ++i) {
      double sum = m_[i][j];
      for (std::size_t n = 0; n < j; ++n) sum -= m_[i][n] * ld[n];
      m_[i][j] = sum * by_d_[j];
    }
  }
}

Six Factor6::solve(const Six& g) const noexcept {
  double v[6] = {g.way.x, g.way.y, g.way.z, g.arc.x, g.arc.y, g.arc.z};
  for (std::size_t i = 1; i < 6; ++i) {
    for (std::size_t j = 0; j < i; ++j) v[i] -= m_[i][j] * v[j];
  }
  for (std::size_t i = 0; i < 6; ++i) v[i] *= by_d_[i];
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t j = i + 1; j < 6; ++j) v[i] -= m_[j][i] * v[j];
  }
  return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
}

void PoseSolver::Work::solve() noexcept {
  if (warm_) keep();
  Z_ = sum();
  sweep();
  if (size() <= 1) {
    Z_ = sum();
    if (certify(1)) return;
  } else if (!warm_) {
    sweep();
  }
  int in_vain = size() > many ? 1 : 0;
  for (int i = 0; i < max_rounds && in_vain < max_rounds_in_vain && any_left(); ++i) {
    if (i > 0) {
      recentre();
      Z_ = sum();
      sweep();
    }
    const double before = best_bound_n_;
    if (round()) return;
    if (i == 0 && warm_ && solve_from_before()) return;
    if (!(best_bound_n_ < 0.5 * before)) ++in_vain;
  }
  augmented_lagrangian();
}

// A plane's force is optimised exactly, all others fixed; of the others a projected step is taken that never loses.
void PoseSolver::Work::sweep() noexcept {
  const auto pull = [&](const Vec3& du, const Foot& foot) { Z_ += wrench(du, foot.beta); };
  for (std::size_t i = 0; i < planes_; ++i) {
    AtFoot<Plane>& p = plane_[i];
    const Foot& foot = feet_[p.foot];
    const double before = p.t;
    p.t = answer(p, before + p.residual(at_foot(Z_, foot.beta)) / p.gain, 1.0 / p.gain);
    if (p.t != before) pull((p.t - before) * p.q, foot);
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    AtFoot<Span>& p = span_[i];
    const Foot& foot = feet_[p.foot];
    const Vec3 before = p.u;
    p.u = p.across(answer(p, before + (1.0 / p.gain) * p.residual(at_foot(Z_, foot.beta)), 1.0 / p.gain));
    pull(p.u - before, foot);
  }
  for (std::size_t i = 0; i < corners_; ++i) {
    AtFoot<Corner>& p = corner_[i];
    const Foot& foot = feet_[p.foot];
    const Vec3 before = p.u;
    p.answer(p.pull(at_foot(Z_, foot.beta), 1.0 / p.gain), 1.0 / p.gain);
    pull(p.u - before, foot);
  }
  count();
}

// Steps of the active set until one settles, and the proof.
bool PoseSolver::Work::round() noexcept {
  for (int i = 0; i < max_steps_in_a_round; ++i) {
    const Step step = active_set_step();
    if (step == Step::settled) break;
    if (step == Step::cut && i + 1 < max_steps_in_a_round) Z_ = sum(), sweep();
  }
  return certify(2);
}

// Warm start from the forces and the motion of the previous balance.
bool PoseSolver::Work::solve_from_before() noexcept {
  restore();
  Z_ = k_ * (moved_m_ - origin_m_);
  for (int i = 0; i < max_rounds_from_before; ++i) {
    if (round()) return true;
  }
  return false;
}

PoseSolver::Work::Step PoseSolver::Work::active_set_step() noexcept {
  const Sides sides = take_sides();
  Six g = sides.g;
  bool slow = false;
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < max_refinements && !slow; ++i) {
    const Moved moved = move(sides.M.solve(g));
    const double size = size_of(moved.left);
    if ((i > 0 && size <= balanced_n_) || !(size < 0.5 * before)) break;
    slow = i > 0 && size > slow_share * before;
    before = size;
    g = moved.left + moved.held;
  }
  if (confine()) return Step::cut;
  return slow ? Step::slow : Step::settled;
}

// States of the primitives, and the resulting system. Sticking primitives keep τR.
PoseSolver::Work::Sides PoseSolver::Work::take_sides() noexcept {
  look();
  for (std::size_t f = 0; f < feet_count_; ++f) feet_[f].u = {}, feet_[f].K = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < planes_; ++i) {
    AtFoot<Plane>& p = plane_[i];
    Foot& foot = feet_[p.foot];
    const double r = p.residual(foot.Z);
    const double w = p.t + r / p.gain;
    if (w <= 0.0) {
      p.state = State::off, p.t = 0.0;
    } else if (w <= p.s * (1.0 + p.compliance / p.gain)) {
      const double stiffness = spring * p.rest;
      p.state = State::stick, p.r = stiffness * (r - p.compliance * p.t);
      foot.u += (p.t + p.r) * p.q;
      foot.K.add(stiffness, p.q);
    } else {
      p.state = State::slip, p.r = r;
      foot.u += (p.s + p.gamma * r) * p.q;
      foot.K.add(p.gamma, p.q);
    }
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    AtFoot<Span>& p = span_[i];
    Foot& foot = feet_[p.foot];
    const double tau = 1.0 / p.gain;
    const Vec3 R = p.residual(foot.Z);
    const Vec3 w = p.u + tau * R;
    const double squared = norm_squared(w);
    double across = spring;
    if (squared <= p.s * p.s) {
      p.state = State::stick, p.R = spring * R;
      foot.u += p.u + p.R;
    } else {
      p.state = State::slip, p.R = R;
      const double asked = std::sqrt(squared);
      const double given = length_given(asked, p.s, p.gamma, tau);
      const Vec3 e = (1.0 / asked) * w;
      across = std::min(spring, given * ((tau + p.gamma) / (asked - p.s)));
      const double along = dot(e, R);
      foot.u += (p.s + p.gamma * along - across * along) * e + across * R;
      foot.K.add(p.gamma - across, e);
    }
    foot.K.add_everywhere(across);
    foot.K.add(-across, p.q);
  }
  for (std::size_t i = 0; i < corners_; ++i) take_side(corner_[i], feet_[corner_[i].foot]);
  Sides sides;
  sides.g = C_ - Z_;
  for (std::size_t f = 0; f < feet_count_; ++f) {
    sides.g += wrench(feet_[f].u, feet_[f].beta);
    sides.M.add(feet_[f].K, feet_[f].beta);
  }
  sides.M.factor();
  count();
  return sides;
}

void PoseSolver::Work::take_side(AtFoot<Corner>& p, Foot& foot) const noexcept {
  const double tau = 1.0 / p.gain;
  const detail::LeastWay way = p.pull(foot.Z, tau);
  double r[most_facets];
  for (std::size_t i = 0; i < p.normals.size(); ++i) r[i] = p.residual(i, foot.Z);
  p.face = way.face;
  p.u = p.face.across(p.u);
  const Vec3 R = p.face.hull(r);
  const double asked = std::sqrt(norm_squared(way.w));
  if (p.face.size == 0) {
    p.state = State::off;
  } else if (asked <= p.s * (1.0 + p.compliance * tau)) {
    const double stiffness = spring * p.rest;
    p.state = State::stick, p.R = stiffness * (R - p.compliance * p.u);
    foot.u += p.u + p.R;
    foot.K.add(stiffness, p.face);
  } else {
    p.state = State::slip, p.R = R;
    const Vec3 e = (1.0 / asked) * way.w;
    const double across = std::min(spring, tau * p.s / (asked - p.s));
    foot.u += (p.s - across * dot(e, R)) * e + across * R;
    foot.K.add(across, p.face);
    foot.K.add(-across, e);
  }
}

// Moves Z by dZ, and every force with its state.
PoseSolver::Work::Moved PoseSolver::Work::move(const Six& dZ) noexcept {
  Z_ += dZ;
  for (std::size_t f = 0; f < feet_count_; ++f) feet_[f].Z = at_foot(dZ, feet_[f].beta), feet_[f].u = {};
  Six held;
  for (std::size_t i = 0; i < planes_; ++i) {
    AtFoot<Plane>& p = plane_[i];
    if (p.state == State::off) continue;
    Foot& foot = feet_[p.foot];
    if (p.state == State::stick) {
      p.r -= spring * p.rest * dot(p.q, foot.Z);
      p.t += p.r;
      p.r *= p.rest;
      held += wrench(p.r * p.q, foot.beta);
    } else {
      p.r -= dot(p.q, foot.Z);
      p.t = p.s + p.gamma * std::max(0.0, p.r);
    }
    foot.u += p.t * p.q;
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    AtFoot<Span>& p = span_[i];
    Foot& foot = feet_[p.foot];
    if (p.state == State::stick) {
      p.R = p.across(p.R - spring * foot.Z);
      p.u += p.R;
      held += wrench(p.R, foot.beta);
    } else {
      const Vec3 R = p.R - p.across(foot.Z);
      const double reach = std::sqrt(norm_squared(R));
      if (reach > 0.0 && dot(p.R + p.u, R) > 0.0) p.u = ((p.s + p.gamma * reach) / reach) * R;
      p.R = R;
    }
    foot.u += p.u;
  }
  for (std::size_t i = 0; i < corners_; ++i) {
    AtFoot<Corner>& p = corner_[i];
    Foot& foot = feet_[p.foot];
    if (p.state == State::stick) {
      p.R = p.face.across(p.R - spring * p.rest * foot.Z);
      p.u += p.R;
      p.R *= p.rest;
      held += wrench(p.R, foot.beta);
    } else if (p.state == State::slip) {
      const Vec3 R = p.R - p.face.across(foot.Z);
      const double reach = std::sqrt(norm_squared(R));
      if (reach > 0.0 && dot(p.R + p.u, R) > 0.0) p.u = (p.s / reach) * R;
      p.R = R;
    }
    foot.u += p.u;
  }
  Six left = C_ - Z_;
  for (std::size_t f = 0; f < feet_count_; ++f) left += wrench(feet_[f].u, feet_[f].beta);
  count();
  return {left, held};
}

// Projects the forces on their admissible sets. Returns whether any was cut by more than rounding.
bool PoseSolver::Work::confine() noexcept {
  bool cut = false;
  for (std::size_t i = 0; i < planes_; ++i) {
    AtFoot<Plane>& p = plane_[i];
    if (p.state != State::stick) continue;
    const double t = std::clamp(p.t, 0.0, p.s);
    cut = cut || std::abs(t - p.t) > balanced_n_;
    p.t = t;
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    AtFoot<Span>& p = span_[i];
    p.u = p.across(p.u);
    if (p.state != State::stick) continue;
    const double squared = norm_squared(p.u);
    if (squared > p.s * p.s) {
      const double length = std::sqrt(squared);
      cut = cut || length - p.s > balanced_n_;
      p.u *= p.s / length;
    }
  }
  for (std::size_t i = 0; i < corners_; ++i) {
    const Vec3 before = corner_[i].u;
    corner_[i].confine(corner_[i].state == State::slip);
    cut = cut || size_of(corner_[i].u - before) > balanced_n_;
  }
  return cut;
}

// Sets the next forces of the multipliers.
void PoseSolver::Work::answer_all(double tau) noexcept {
  look();
  for (std::size_t i = 0; i < planes_; ++i) {
    AtFoot<Plane>& p = plane_[i];
    p.t = answer(p, p.t + tau * p.residual(feet_[p.foot].Z), tau);
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    AtFoot<Span>& p = span_[i];
    p.u = p.across(answer(p, p.u + tau * p.residual(feet_[p.foot].Z), tau));
  }
  for (std::size_t i = 0; i < corners_; ++i) {
    AtFoot<Corner>& p = corner_[i];
    p.answer(p.pull(feet_[p.foot].Z, tau), tau);
  }
}

void PoseSolver::Work::augmented_lagrangian() noexcept {
  // Failed steps can leave forces far beyond s where a drag is large: no good start.
  for (std::size_t i = 0; i < planes_; ++i) plane_[i].t = std::min(plane_[i].t, plane_[i].s);
  for (std::size_t i = 0; i < spans_; ++i) span_[i].u = shortened(span_[i].u, span_[i].s);
  Z_ = sum();
  double tau = warm_ ? warm_penalty : cold_penalty;
  for (int i = 0; i < max_penalties && any_left(); ++i) {
    recentre();
    if (!minimise(tau) && tau <= unsteady_penalty) {
      tau = std::max(1.0, 1e-2 * tau);
      continue;
    }
    answer_all(tau);
    if (certify(3)) return;
    if (i == 0 || tau > steady_penalty) {
      recentre();
      keep();
      active_set_step();
      if (certify(3)) return;
      restore();
    }
    tau = std::min(largest_penalty, next_penalty * tau);
  }
}

// Newton's method for Ψ, to the precision that the forces of this τ need. Returns whether it converged.
bool PoseSolver::Work::minimise(double tau) noexcept {
  for (int step = 0; step < max_newton_steps && any_left(); ++step) {
    look();
    for (std::size_t f = 0; f < feet_count_; ++f) feet_[f].u = {}, feet_[f].K = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    double size = size_of(C_);
    for (std::size_t i = 0; i < planes_; ++i) {
      const AtFoot<Plane>& p = plane_[i];
      Foot& foot = feet_[p.foot];
      const double w = p.t + tau * p.residual(foot.Z);
      const double t = answer(p, w, tau);
      foot.u += t * p.q;
      size += t;
      const double yields = 1.0 + p.compliance * tau;
      if (w > 0.0) foot.K.add(w <= p.s * yields ? tau / yields : tau * (p.gamma / (tau + p.gamma)), p.q);
    }
    for (std::size_t i = 0; i < spans_; ++i) {
      const AtFoot<Span>& p = span_[i];
      Foot& foot = feet_[p.foot];
      const Vec3 w = p.u + tau * p.residual(foot.Z);
      const double squared = norm_squared(w);
      double across = tau;
      if (squared <= p.s * p.s) {
        foot.u += w;
      } else {
        const double asked = std::sqrt(squared);
        const double share = length_given(asked, p.s, p.gamma, tau) / asked;
        foot.u += share * w;
        across = tau * share;
        foot.K.add(tau * (p.gamma / (tau + p.gamma)) - across, (1.0 / asked) * w);
      }
      size += size_of(p.u);
      foot.K.add_everywhere(across);
      foot.K.add(-across, p.q);
    }
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
      if (slips) foot.K.add(-tau * share, (1.0 / asked) * way.w);
    }
    Six g = C_ - Z_;  // −∇Ψ
    Factor6 M;
    for (std::size_t f = 0; f < feet_count_; ++f) {
      g += wrench(feet_[f].u, feet_[f].beta);
      M.add(feet_[f].K, feet_[f].beta);
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
  double low = 0.0, at_low = slope_at_start;
  double high = 1.0, at_high = slope(Z_ + d, d, tau);
  if (at_high <= 0.0) return high;
  for (int i = 0; i < max_search_steps && any_left(); ++i) {
    const double secant = low + (high - low) * (at_low / (at_low - at_high));
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
double PoseSolver::Work::slope(const Six& at, const Six& d, double tau) noexcept {
  for (std::size_t f = 0; f < feet_count_; ++f) {
    feet_[f].Z = at_foot(at, feet_[f].beta);
    feet_[f].u = at_foot(d, feet_[f].beta);
  }
  double slope = dot(at - C_, d);
  for (std::size_t i = 0; i < planes_; ++i) {
    const AtFoot<Plane>& p = plane_[i];
    slope -= answer(p, p.t + tau * p.residual(feet_[p.foot].Z), tau) * dot(p.q, feet_[p.foot].u);
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    const AtFoot<Span>& p = span_[i];
    slope -= dot(answer(p, p.u + tau * p.residual(feet_[p.foot].Z), tau), feet_[p.foot].u);
  }
  for (std::size_t i = 0; i < corners_; ++i) {
    const AtFoot<Corner>& p = corner_[i];
    const Foot& foot = feet_[p.foot];
    slope -= dot(shortened(p.pull(foot.Z, tau).w / (1.0 + p.compliance * tau), p.s), foot.u);
  }
  rows_ += static_cast<int>(size());
  return slope;
}

}  // namespace palpa
