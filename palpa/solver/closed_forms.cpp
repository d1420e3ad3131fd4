// Balances of few primitives, in closed form and by sweeps.
#include "palpa/solver/solver_work.h"

namespace palpa {

using namespace detail::solving;

// 1. Sweeps: block coordinate descent of the dual. With all forces but u held, Z without it is Z − u, and u is the response to
// the pull P(B − (Z − u)) = R + u of the coupling itself.
void Solver::Work::sweep() noexcept {
  Vec3 Z = Z_;
  for (std::size_t i = 0; i < plane_count_; ++i) {
    Plane& p = planes_[i];
    const double t = answer(p, p.residual(Z) + p.t, 1.0);
    Z += (t - p.t) * p.q;
    p.t = t;
  }
  for (std::size_t i = 0; i < span_count_; ++i) {
    Span& p = spans_[i];
    const Vec3 u = answer(p, p.across(p.B - Z + p.u), 1.0);
    Z += u - p.u;
    p.u = u;
  }
  for (std::size_t i = 0; i < corner_count_; ++i) {
    Corner& p = corners_[i];
    const Vec3 before = p.u;
    p.answer(p.pull(Z, 1.0, p.face), 1.0);
    Z += p.u - before;
  }
  Z_ = Z;
}

// Points with a common anchor, the others without drag: φ of the points together is a function of |R| alone, and that of the
// others is homogeneous, so the balance is that of the others, drawn towards the anchor as by one point with the strength and
// drag of all. The proxy stays on the primitives that it rested on.
void Solver::Work::add_common_points() noexcept {
  double s = 0.0, gamma = 0.0;
  for (std::size_t i = line_count_; i < all_spans_; ++i) s += spans_[i].s, gamma += spans_[i].gamma;
  const Vec3& B = spans_[line_count_].B;
  const Vec3 w = B - Z_;
  const double asked = std::sqrt(norm_squared(w));
  span_count_ = all_spans_;
  if (asked > s) {
    const double beyond = (asked - s) / (1.0 + gamma);
    const Vec3 e = (1.0 / asked) * w;
    for (std::size_t i = line_count_; i < all_spans_; ++i) spans_[i].u = (spans_[i].s + spans_[i].gamma * beyond) * e;
    if (s > 0.0 || gamma > 0.0) Z_ = B - beyond * e;
  } else {
    for (std::size_t i = line_count_; i < all_spans_; ++i) spans_[i].u = s > 0.0 ? (spans_[i].s / s) * w : Vec3{};
    Z_ = B;
  }
}

// A single primitive, or a plane and a line with one direction (a surface and its friction), whose spans are orthogonal: a
// sweep is the closed form. The balance moves by no more than C, the anchors and the strengths do, so its error is their
// rounding and the sweep's own. Where that would show in the duality gap, with its root, the stages are used.
bool Solver::Work::in_closed_form() noexcept {
  if (corner_count_ > 0) return corner_in_closed_form();
  const bool one = plane_count_ + all_spans_ == 1;
  const bool surface = plane_count_ == 1 && line_count_ == 1 && all_spans_ == 1 && planes_[0].q == spans_[0].q;
  if (!one && !surface) return false;
  double size = C_size_ + directed_size_n_, longest = 0.0, gamma = 0.0;
  if (plane_count_ == 1) size += planes_[0].size + planes_[0].s, longest = planes_[0].s, gamma = planes_[0].gamma;
  if (all_spans_ == 1) {
    size += spans_[0].size + spans_[0].s;
    longest = std::max(longest, spans_[0].s), gamma = std::max(gamma, spans_[0].gamma);
  }
  const double rounding = (16.0 + directed_terms_) * epsilon * size;
  if (shows_in_gap(epsilon * size, longest, gamma)) return false;
  // From zero forces: a warm start's can be far longer, a drag's above all, and would leave their rounding.
  Z_ = C_;
  if (plane_count_ == 1) planes_[0].t = 0.0;
  if (all_spans_ == 1) spans_[0].u = {};
  sweep();
  best_Z_ = Z_;
  best_bound_n_ = rounding;
  best_stage_ = 1, iterations_ = 1;
  done_ = true;
  return true;
}

// A corner with a single holding facet, with or without a line along that facet's normal, is that plane: at its nearest
// feasible point, all its other facets are satisfied. The newest facet is tried first.
bool Solver::Work::corner_in_closed_form() noexcept {
  if (corner_count_ > 1 || plane_count_ > 0 || all_spans_ > 1 || line_count_ != all_spans_) return false;
  Corner& corner = corners_[0];
  for (std::size_t j = corner.normals.size(); j-- > 0;) {
    const Vec3& n = corner.normals[j];
    if (all_spans_ == 1 && spans_[0].q != n) continue;
    const double longest = std::max(corner.s, all_spans_ == 1 ? spans_[0].s : 0.0);
    double size = C_size_ + directed_size_n_ + std::abs(corner.b[j]) + corner.s;
    if (all_spans_ == 1) size += spans_[0].size + spans_[0].s;
    if (shows_in_gap(epsilon * size, longest, all_spans_ == 1 ? spans_[0].gamma : 0.0)) return false;
    const double behind = std::max(0.0, corner.residual(j, C_));
    const double t = std::min(behind / (1.0 + corner.compliance), corner.s);
    const Vec3 u = all_spans_ == 1 ? answer(spans_[0], spans_[0].residual(C_), 1.0) : Vec3{};
    const Vec3 Z = C_ + t * n + u;
    const Vec3 on_facet = C_ + behind * n + u;
    const double rounding = (16.0 + directed_terms_) * epsilon * size;
    bool left = true;
    for (std::size_t i = 0; i < corner.normals.size(); ++i) {
      left = left && (i == j || corner.residual(i, on_facet) < -(rounding + detail::plane_rounding * std::abs(corner.b[i])));
    }
    if (!left) continue;
    corner.face.size = 0;
    corner.face.take(static_cast<int>(j), n);
    corner.u = t * n, corner.t[0] = t;
    if (all_spans_ == 1) spans_[0].u = u;
    best_Z_ = Z;
    best_bound_n_ = rounding;
    best_stage_ = 1, iterations_ = 1;
    done_ = true;
    return true;
  }
  return false;
}

}  // namespace palpa
