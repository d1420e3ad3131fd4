// Newton steps on the primitives that stick and slip.
#include "palpa/solver/solver_work.h"

namespace palpa {

using namespace detail::solving;

// 2. Active set. With w = R + u the pull as in a sweep, a primitive sticks where |w| ≤ s; there R = 0 is demanded, by a spring
// of stiffness τ that starts from u. Where it slips, its force is s + γ|R| along e = w/|w|, and for a move dZ it changes by −γ
// along e and by −K across it, K = |u|/(|w| − |u|) with the |u| in response to w. Together this is a linear system for dZ:
//     M dZ = C + Σ(force at dZ = 0) − Z,   M = I + ΣK.
// The spring leaves R = (u⁺ − u)/τ, and the turn of the slipping forces leaves a force. Solving again with this M, for that
// force and that R (not as a difference of large numbers), reduces both to rounding. Where that converges slowly M is rebuilt,
// and where a force had to be cut to its admissible set, a sweep renews the states.
Solver::Work::Step Solver::Work::active_set_step() noexcept {
  const Sides sides = take_sides();
  const Factor factor(sides.M);
  Vec3 g = sides.g;
  bool slow = false;
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < max_refinements && !slow; ++i) {
    const Moved moved = move(factor.solve(g));
    const double size = size_of(moved.left);
    // Also ends when the residual force no longer halves: it is rounding, or it grows. More: useless refinements; less: slow
    // but useful ones are dropped.
    if ((i > 0 && size <= balanced_n_) || !(size < 0.5 * before)) break;
    slow = i > 0 && size > slow_share * before;
    before = size;
    g = moved.left + moved.held;
  }
  if (confine()) return Step::cut;
  return slow ? Step::slow : Step::settled;
}

// States of the primitives, and the resulting system: M, and its right side. Sticking primitives keep τR.
Solver::Work::Sides Solver::Work::take_sides() noexcept {
  const Vec3 Z = Z_;
  Stiffness M;
  Vec3 g = C_ - Z;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    const double r = p.residual(Z);
    const double w = r + p.t;
    if (w <= 0.0) {
      p.state = State::off, p.t = 0.0;
    } else if (w <= p.s * (1.0 + p.compliance)) {
      const double stiffness = spring * p.rest;
      p.state = State::stick, p.r = stiffness * (r - p.compliance * p.t);
      g += (p.t + p.r) * p.q;
      M.add(stiffness, p.q);
    } else {
      p.state = State::slip, p.r = r;
      g += (p.s + p.gamma * r) * p.q;
      M.add(p.gamma, p.q);
    }
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    const Vec3 R = p.residual(Z);
    const Vec3 w = R + p.u;
    const double squared = norm_squared(w);
    double across = spring;
    if (squared <= p.s * p.s) {
      p.state = State::stick, p.R = spring * R;
      g += p.u + p.R;
    } else {
      p.state = State::slip, p.R = R;
      const double asked = std::sqrt(squared);
      const double given = length_given(asked, p.s, p.gamma, 1.0);
      const Vec3 e = (1.0 / asked) * w;
      across = std::min(spring, given * ((1.0 + p.gamma) / (asked - p.s)));
      const double along = dot(e, R);
      g += (p.s + p.gamma * along - across * along) * e + across * R;
      M.add(p.gamma - across, e);
    }
    M.add_everywhere(across);
    M.add(-across, p.q);
  }
  for (std::size_t i = 0; i < corner_count_; ++i) take_side(corners_[i], M, g);
  return {M, g};
}

// A corner acts within the span of the face found by a sweep: its R is the vector to that face's hull.
void Solver::Work::take_side(Corner& p, Stiffness& M, Vec3& g) const noexcept {
  const detail::LeastWay way = p.pull(Z_, 1.0, p.face);
  double r[most_facets];
  for (std::size_t i = 0; i < p.normals.size(); ++i) r[i] = p.residual(i, Z_);
  p.face = way.face;
  p.u = p.face.across(p.u);
  const Vec3 R = p.face.hull(r);
  const double squared = norm_squared(way.w);
  if (p.face.size == 0) {
    p.state = State::off;
  } else if (std::sqrt(squared) <= p.s * (1.0 + p.compliance)) {
    const double stiffness = spring * p.rest;
    p.state = State::stick, p.R = stiffness * (R - p.compliance * p.u);
    g += p.u + p.R;
    M.add(stiffness, p.face);
  } else {
    p.state = State::slip, p.R = R;
    const double asked = std::sqrt(squared);
    const Vec3 e = (1.0 / asked) * way.w;
    const double across = std::min(spring, p.s / (asked - p.s));
    g += (p.s - across * dot(e, R)) * e + across * R;
    M.add(across, p.face);
    M.add(-across, e);
  }
}

// Moves Z by dZ, and every force with its state.
Solver::Work::Moved Solver::Work::move(const Vec3& dZ) noexcept {
  Z_ += dZ;
  Vec3 left = C_ - Z_, held;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    if (p.state == State::off) continue;
    if (p.state == State::stick) {
      p.r -= spring * p.rest * dot(p.q, dZ);
      p.t += p.r;
      p.r *= p.rest;
      held += p.r * p.q;
    } else {
      p.r -= dot(p.q, dZ);
      p.t = p.s + p.gamma * std::max(0.0, p.r);
    }
    left += p.t * p.q;
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    if (p.state == State::stick) {
      p.R = p.across(p.R - spring * dZ);
      p.u += p.R;
      held += p.R;
    } else {
      const Vec3 R = p.R - p.across(dZ);
      const double reach = std::sqrt(norm_squared(R));
      if (reach > 0.0 && dot(p.R + p.u, R) > 0.0) {  // else it would pass its anchor: it keeps its force
        p.u = ((p.s + p.gamma * reach) / reach) * R;
      }
      p.R = R;
    }
    left += p.u;
  }
  for (std::size_t i = 0; i < corner_count_; ++i) {
    Corner& p = corners_[i];
    if (p.state == State::stick) {
      p.R = p.face.across(p.R - spring * p.rest * dZ);
      p.u += p.R;
      p.R *= p.rest;
      held += p.R;
    } else if (p.state == State::slip) {
      const Vec3 R = p.R - p.face.across(dZ);
      const double reach = std::sqrt(norm_squared(R));
      if (reach > 0.0 && dot(p.R + p.u, R) > 0.0) p.u = (p.s / reach) * R;
      p.R = R;
    }
    left += p.u;
  }
  return {left, held};
}

// Projects the forces on their admissible sets: of primitives wrongly assumed to stick, and of rounding along a line. Returns
// whether any was cut by more than rounding.
bool Solver::Work::confine() noexcept {
  bool cut = false;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    if (p.state != State::stick) continue;
    const double t = std::clamp(p.t, 0.0, p.s);
    cut = cut || std::abs(t - p.t) > balanced_n_;
    p.t = t;
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    p.u = p.across(p.u);
    if (p.state != State::stick) continue;
    const double squared = norm_squared(p.u);
    if (squared > p.s * p.s) {
      const double length = std::sqrt(squared);
      cut = cut || length - p.s > balanced_n_;
      p.u *= p.s / length;
    }
  }
  for (std::size_t i = 0; i < corner_count_; ++i) {
    const Vec3 before = corners_[i].u;
    corners_[i].confine(corners_[i].state == State::slip);
    cut = cut || size_of(corners_[i].u - before) > balanced_n_;
  }
  return cut;
}

// Warm start from the forces and the proxy's motion of the previous balance, which are nearly the new ones: together they show
// which primitives slip, and in which direction, even if they slip little. The forces alone do not.
bool Solver::Work::solve_from_before() noexcept {
  restore();
  Z_ = k_ * moved_m_;
  for (int i = 0; i < max_rounds_from_before; ++i) {
    if (round()) return true;
  }
  return false;
}

// Steps of the active set until one settles, and the proof.
bool Solver::Work::round() noexcept {
  for (int i = 0; i < max_steps_in_a_round; ++i) {
    const Step step = active_set_step();
    if (step == Step::settled) break;
    if (step == Step::cut && i + 1 < max_steps_in_a_round) Z_ = sum(), sweep();
  }
  return certify(2);
}

}  // namespace palpa
