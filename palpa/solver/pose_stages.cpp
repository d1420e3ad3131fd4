// Stages of a tool's balance: working set, sweep, active set. Each is that of the point (closed_forms.cpp, active_set.cpp) with
// J Z in place of Z; in its pull w = u + R/A the compliance A of the coupling at the foot is that along
// the primitive, 1 + |β × q|², or at most 1 + |β|².
#include "palpa/solver/pose_work.h"

namespace palpa {

using namespace detail::solving;
using namespace detail::posing;

namespace {
// [1] Rounds of the active set in a row. More: a longer worst case; fewer: more balances need multipliers.
constexpr int max_rounds_ahead = 2;
// [1] Change of a slip's R in a step, as a share of R, up to which its force follows R. More: small slips overshoot; less:
// sides are taken again in vain.
constexpr double most_turn_of_slip = 0.3;
// [1] Planes that a round of the working set takes in, and their number above which it takes all. More: more planes in each
// pass; fewer: more rounds.
constexpr std::size_t most_taken_in = 4, many_pressed = 16;
// [1] Lines and points above which a cold start goes to the multipliers at once. More: a longer worst case; fewer: easy
// balances take longer.
constexpr std::size_t many_jammed = 32;
}  // namespace

void Factor6::add(const Stiffness& K, const Vec3& beta) noexcept {
  way_.xx += K.xx, way_.xy += K.xy, way_.xz += K.xz, way_.yy += K.yy, way_.yz += K.yz, way_.zz += K.zz;
  // With B = β×, the lower left block is B K, whose columns are β × those of K; the lower right one (B K) Bᵀ.
  const Vec3 x = cross(beta, {K.xx, K.xy, K.xz}), y = cross(beta, {K.xy, K.yy, K.yz}), z = cross(beta, {K.xz, K.yz, K.zz});
  const Vec3 rows[3] = {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
  for (std::size_t i = 0; i < 3; ++i) rows_[i] += rows[i];
  const Vec3 second = cross(beta, rows[1]), third = cross(beta, rows[2]);
  arc_.xx += beta.y * rows[0].z - beta.z * rows[0].y;
  arc_.xy += second.x, arc_.yy += second.y;
  arc_.xz += third.x, arc_.yz += third.y, arc_.zz += third.z;
}

void Factor6::factor() noexcept {
  l_ = {{{way_.xx},
         {way_.xy, way_.yy},
         {way_.xz, way_.yz, way_.zz},
         {rows_[0].x, rows_[0].y, rows_[0].z, arc_.xx},
         {rows_[1].x, rows_[1].y, rows_[1].z, arc_.xy, arc_.yy},
         {rows_[2].x, rows_[2].y, rows_[2].z, arc_.xz, arc_.yz, arc_.zz}}};
  std::array<double, 6> pivots{};
  for (std::size_t j = 0; j < 6; ++j) {
    double d = l_[j][j];
    std::array<double, 6> ld{};  // L D of row j
    for (std::size_t n = 0; n < j; ++n) {
      ld[n] = l_[j][n] * pivots[n];
      d -= l_[j][n] * ld[n];
    }
    pivots[j] = std::max(1.0, d);
    by_d_[j] = 1.0 / pivots[j];
    for (std::size_t i = j + 1; i < 6; ++i) {
      double sum = l_[i][j];
      for (std::size_t n = 0; n < j; ++n) sum -= l_[i][n] * ld[n];
      l_[i][j] = sum * by_d_[j];
    }
  }
}

Six Factor6::solve(const Six& g) const noexcept {
  double v[6] = {g.way.x, g.way.y, g.way.z, g.arc.x, g.arc.y, g.arc.z};
  for (std::size_t i = 1; i < 6; ++i) {
    for (std::size_t j = 0; j < i; ++j) v[i] -= l_[i][j] * v[j];
  }
  for (std::size_t i = 0; i < 6; ++i) v[i] *= by_d_[i];
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t j = i + 1; j < 6; ++j) v[i] -= l_[j][i] * v[j];
  }
  return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
}

// Balances the working set, and takes planes in until no other is pressed.
void PoseSolver::Work::solve() noexcept {
  for (;;) {
    const bool is_proven = solve_set();
    if (rest_count_ == 0 || (is_proven && !widen())) return;
    if (!is_proven) {
      while (rest_count_ > 0) take_in(rest_count_ - 1);
    }
    best_bound_n_ = std::numeric_limits<double>::max();
    warm_ = true;
    if (!any_left()) {
      certify(3);
      if (rest_count_ == 0) return;
    }
  }
}

bool PoseSolver::Work::solve_set() noexcept {
  if (warm_) keep();
  Z_ = sum();
  if (size() == 0) return certify(1);
  sweep();
  if (size() == 1) {
    Z_ = sum();
    if (certify(1)) return true;
  } else if (!warm_) {
    sweep();
  }
  // A cold start of many lines and points needs multipliers anyway.
  int in_vain = !warm_ && spans_ > many_jammed ? max_rounds_in_vain : size() > many ? 1 : 0;
  for (int i = 0; i < max_rounds && in_vain < max_rounds_in_vain && any_left(); ++i) {
    if (i > 0) {
      recentre();
      Z_ = sum();
      sweep();
    }
    const double before = best_bound_n_;
    if (advance()) return true;
    if (warm_) {
      restore();
      break;
    }
    if (!(best_bound_n_ < 0.5 * before)) ++in_vain;
  }
  return augmented_lagrangian();
}

void PoseSolver::Work::take_in(std::size_t place) noexcept {
  pose_plane(rest_[place], 0.0);
  anchor(plane_[planes_ - 1]);
  rest_[place] = rest_[--rest_count_];
}

// Depth of the best balance behind a plane [N], raised by its rounding.
double PoseSolver::Work::depth_n(const Primitive& p) const noexcept {
  const Vec3& lever_m = step_.levers_m[p.id.foot];
  const Vec3 turn_rad = best_m_.arc / step_.turning_radius_m;
  const Vec3 offset_m = p.position_m - step_.foot_m(p.id.foot), way_m = best_m_.way + cross(turn_rad, lever_m);
  const double size_m = size_of(offset_m) + size_of(best_m_.way) + 2.0 * size_of(turn_rad) * size_of(lever_m);
  return k_ * (dot(p.direction, offset_m - way_m) + 10.0 * epsilon * size_m);
}

// Takes in planes that the best balance presses: the deepest, or all if there are many. If there is none, adds to the bound
// what the rest can press within rounding.
bool PoseSolver::Work::widen() noexcept {
  double* const depths_n = kept_planes_n_.get();
  std::size_t pressed = 0;
  double gap_n2 = 0.0;
  for (std::size_t i = 0; i < rest_count_; ++i) {
    const Primitive& p = primitives_[rest_[i]];
    const double depth = std::max(0.0, depth_n(p));
    const double gap = depth > 0.0 ? (p.strength_n + detail::gamma_of(p, k_, step_.time_step_s) * depth) * depth : 0.0;
    const bool is_pressed = gap > shown_n2_;
    depths_n[i] = is_pressed ? depth : 0.0;
    pressed += is_pressed;
    if (!is_pressed) gap_n2 += gap;
  }
  rows_ += static_cast<int>(rest_count_);
  if (pressed == 0) {
    best_bound_n_ = bound_of(best_left_n_, best_gap_n2_ + gap_n2) * best_share_;
    return false;
  }
  // From the back: a place is filled by the last.
  for (std::size_t i = rest_count_; pressed > many_pressed && i-- > 0;) {
    if (depths_n[i] > 0.0) take_in(i);
  }
  for (std::size_t taken = 0; pressed <= many_pressed && taken < std::min(pressed, most_taken_in); ++taken) {
    double* const deepest = std::max_element(depths_n, depths_n + rest_count_);
    take_in(static_cast<std::size_t>(deepest - depths_n));
    *deepest = depths_n[rest_count_];
  }
  return true;
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
    FootSpan& p = span_[i];
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

// Rounds while each leaves a tenth of the bound at most: where feet slip, the sides settle before their directions do.
bool PoseSolver::Work::advance() noexcept {
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < max_rounds_ahead; ++i) {
    if (round()) return true;
    if (!(bound_n_ < 0.1 * before)) break;
    before = bound_n_;
  }
  return false;
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

PoseSolver::Work::Step PoseSolver::Work::active_set_step() noexcept {
  const Sides sides = take_sides();
  Six g = sides.g;
  bool slow = false;
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < max_refinements && !slow; ++i) {
    const Moved moved = move(sides.M.solve(g));
    const double size = size_of(moved.left);
    if ((i > 0 && size <= balanced_n_) || !(size < 0.5 * before)) break;
    slow = i > 0 && (moved.turned || size > slow_share * before);
    before = size;
    g = moved.left + moved.held;
  }
  if (confine()) return Step::cut;
  return slow ? Step::slow : Step::settled;
}

// States of the primitives, and the resulting system. Sticking primitives keep τR.
PoseSolver::Work::Sides PoseSolver::Work::take_sides() noexcept {
  look();
  for (std::size_t f = 0; f < feet_count_; ++f) feet_[f].u = {}, feet_[f].K = Foot::none, feet_[f].is_stiff = false;
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
      foot.stiffen(stiffness, p.q);
    } else {
      p.state = State::slip, p.r = r;
      foot.u += (p.s + p.gamma * r) * p.q;
      if (p.gamma > 0.0) foot.stiffen(p.gamma, p.q);
    }
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    FootSpan& p = span_[i];
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
      p.e = e, p.at = R, p.stiffness_across = across;
      const double along = dot(e, R);
      foot.u += (p.s + p.gamma * along - across * along) * e + across * R;
      foot.K.add(p.gamma - across, e);
    }
    foot.K.add_everywhere(across), foot.is_stiff = true;
    foot.K.add(-across, p.q);
  }
  for (std::size_t i = 0; i < corners_; ++i) take_side(corner_[i], feet_[corner_[i].foot]);
  Sides sides;
  sides.g = C_ - Z_;
  for (std::size_t f = 0; f < feet_count_; ++f) {
    sides.g += wrench(feet_[f].u, feet_[f].beta);
    if (feet_[f].is_stiff) sides.M.add(feet_[f].K, feet_[f].beta);
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
    foot.K.add(stiffness, p.face), foot.is_stiff = true;
  } else {
    p.state = State::slip, p.R = R;
    const Vec3 e = (1.0 / asked) * way.w;
    const double across = std::min(spring, tau * p.s / (asked - p.s));
    foot.u += (p.s - across * dot(e, R)) * e + across * R;
    foot.K.add(across, p.face), foot.is_stiff = true;
    foot.K.add(-across, e);
  }
}

// Moves Z by dZ, and every force with its state.
PoseSolver::Work::Moved PoseSolver::Work::move(const Six& dZ) noexcept {
  Z_ += dZ;
  for (std::size_t f = 0; f < feet_count_; ++f) feet_[f].Z = at_foot(dZ, feet_[f].beta), feet_[f].u = {};
  Moved moved;
  for (std::size_t i = 0; i < planes_; ++i) {
    AtFoot<Plane>& p = plane_[i];
    if (p.state == State::off) continue;
    Foot& foot = feet_[p.foot];
    if (p.state == State::stick) {
      p.r -= spring * p.rest * dot(p.q, foot.Z);
      p.t += p.r;
      p.r *= p.rest;
      moved.held += wrench(p.r * p.q, foot.beta);
    } else {
      p.r -= dot(p.q, foot.Z);
      p.t = p.s + p.gamma * std::max(0.0, p.r);
    }
    foot.u += p.t * p.q;
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    FootSpan& p = span_[i];
    Foot& foot = feet_[p.foot];
    if (p.state == State::stick) {
      p.R = p.across(p.R - spring * foot.Z);
      p.u += p.R;
      moved.held += wrench(p.R, foot.beta);
    } else {
      moved.turned = slip(p, p.R - p.across(foot.Z)) || moved.turned;
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
      moved.held += wrench(p.R, foot.beta);
    } else if (p.state == State::slip) {
      const Vec3 R = p.R - p.face.across(foot.Z);
      const double reach = std::sqrt(norm_squared(R));
      if (reach > 0.0 && dot(p.R + p.u, R) > 0.0) p.u = (p.s / reach) * R;
      p.R = R;
    }
    foot.u += p.u;
  }
  moved.left = C_ - Z_;
  for (std::size_t f = 0; f < feet_count_; ++f) moved.left += wrench(feet_[f].u, feet_[f].beta);
  count();
  return moved;
}

// Moves the force of a slip to R: along R; where the step turns R by much, as the step's linear model has it, for a small R may
// then have any direction. Returns whether it is the latter.
bool PoseSolver::Work::slip(FootSpan& p, const Vec3& R) noexcept {
  p.R = R;
  const double reach = norm(R);
  const bool turns = !(norm(R - p.at) <= most_turn_of_slip * reach);
  const double along = turns ? std::max(0.0, palpa::dot(p.e, R)) : reach;
  const Vec3 way = turns ? p.s * p.e + p.stiffness_across * (R - palpa::dot(p.e, R) * p.e) : R;
  const double length = norm(way);
  if (length > 0.0) p.u = ((p.s + p.gamma * along) / length) * way;
  return turns;
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
    FootSpan& p = span_[i];
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

}  // namespace palpa
