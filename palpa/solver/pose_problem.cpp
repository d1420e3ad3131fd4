// Poses a tool's problem in newtons, and proves iterates.
#include <limits>

#include "palpa/solver/pose_work.h"

namespace palpa {

using namespace detail::solving;
using namespace detail::posing;

PoseSolver::Work::Work(std::size_t capacity, std::size_t feet)
    : numbers_(std::make_unique<std::uint16_t[]>(feet)),
      feet_(std::make_unique<Foot[]>(feet)),
      plane_(std::make_unique<AtFoot<Plane>[]>(capacity)),
      span_(std::make_unique<FootSpan[]>(capacity)),
      corner_(std::make_unique<AtFoot<Corner>[]>(capacity / 2)),
      normals_(std::make_unique<Vec3[]>(capacity)),
      offsets_n_(std::make_unique<double[]>(capacity)),
      all_feet_(feet),
      rest_(std::make_unique<std::uint32_t[]>(capacity)),
      plane_rays_(std::make_unique<PlaneRay[]>(capacity)),
      span_rays_(std::make_unique<SpanRay[]>(capacity)),
      kept_planes_n_(std::make_unique<double[]>(capacity)),
      kept_spans_n_(std::make_unique<Vec3[]>(capacity)),
      kept_corners_(std::make_unique<Corner[]>(capacity / 2)),
      best_forces_n_(std::make_unique<Vec3[]>(capacity)) {}

// Place in feet_ of a primitive's foot, added if it has none.
std::uint16_t PoseSolver::Work::foot_of(const Primitive& primitive, const ToolStep& step) noexcept {
  constexpr auto none = std::numeric_limits<std::uint16_t>::max();
  std::uint16_t& number = numbers_[primitive.id.foot];
  if (number != none) return number;
  number = static_cast<std::uint16_t>(feet_count_++);
  Foot& foot = feet_[number];
  foot.lever_m = step.levers_m[primitive.id.foot];
  foot.beta = (1.0 / step.turning_radius_m) * foot.lever_m;
  foot.start_m = step.foot_m(primitive.id.foot);
  foot.gain = 1.0 + norm_squared(foot.beta);
  foot.size = detail::size_of(foot.beta);
  return number;
}

void PoseSolver::Work::pose(std::span<const Primitive> primitives, const Vec3* warm_n, const ToolStep& step,
                            bool whole) noexcept {
  primitives_ = primitives;
  step_ = step;
  k_ = step.stiffness_n_per_m, by_k_ = 1.0 / k_;
  wanted_n_ = k_ * wanted_bound_m;
  balanced_n_ = refined_share * wanted_n_;
  shown_n2_ = 0.1 * wanted_n_ * wanted_n_ / static_cast<double>(std::max<std::size_t>(1, primitives.size()));
  precise_ = anchored_precisely_ = warm_ = false;
  strongest_n_ = 0.0;
  best_bound_n_ = std::numeric_limits<double>::max();
  best_m_ = best_rest_n_ = origin_m_ = {};
  iterations_ = rows_ = 0;
  feet_count_ = planes_ = spans_ = corners_ = facets_ = rest_count_ = 0;
  std::fill_n(numbers_.get(), all_feet_, std::numeric_limits<std::uint16_t>::max());

  way_n_ = {k_ * (step.probe.position_m - step.start.position_m),
            k_ * (step.turning_radius_m * rotation_between_rad(step.start.turn, step.probe.turn))};
  directed_n_ = {};
  directed_size_n_ = directed_terms_ = 0.0;
  bool only_planes = true;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    warm_ = warm_ || warm_n[i] != Vec3{};
    only_planes = only_planes && (primitives[i].kind == PrimitiveKind::plane || primitives[i].kind == PrimitiveKind::directed);
  }
  // With other kinds, or where many planes are opposed, a cold start without them would be a detour.
  constexpr std::size_t few_planes = 64;
  const bool has_rest = !whole && (warm_ || (only_planes && primitives.size() <= few_planes));
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    if (p.kind == PrimitiveKind::directed) {
      const Foot& foot = feet_[foot_of(p, step)];
      directed_n_ += wrench(p.strength_n * p.direction, foot.beta);
      directed_size_n_ += 4.0 * p.strength_n * (1.0 + foot.size);
      directed_terms_ += 1.0;
      continue;
    }
    const std::size_t facets = p.kind == PrimitiveKind::corner ? whole_of(primitives, i).size() : 1;
    if (facets > 1) {
      pose_corner(i, facets, warm_n);
      i += facets - 1;
    } else if (p.kind == PrimitiveKind::point || p.kind == PrimitiveKind::line) {
      pose_span(i, warm_n[i]);
    } else if (const double t = dot(p.direction, warm_n[i]); has_rest && !(t > 0.0)) {
      rest_[rest_count_++] = static_cast<std::uint32_t>(i);
      best_forces_n_[i] = {};
    } else {
      pose_plane(i, t);
    }
  }
  anchor_all();
}

void PoseSolver::Work::pose_plane(std::size_t i, double t) noexcept {
  const Primitive& p = primitives_[i];
  AtFoot<Plane>& plane = plane_[planes_++];
  plane.q = p.direction, plane.s = p.strength_n, plane.index = static_cast<std::uint32_t>(i);
  plane.gamma = detail::gamma_of(p, k_, step_.time_step_s);
  plane.compliance = detail::compliance_of(p, k_);
  plane.rest = rest_of_spring(plane.compliance);
  plane.t = std::max(0.0, plane.gamma > 0.0 ? t : std::min(t, plane.s));
  plane.foot = foot_of(p, step_), plane.gain = 1.0 + norm_squared(cross(feet_[plane.foot].beta, plane.q));
  strongest_n_ = std::max(strongest_n_, plane.s);
}

void PoseSolver::Work::pose_span(std::size_t i, const Vec3& warm_n) noexcept {
  const Primitive& p = primitives_[i];
  FootSpan& span = span_[spans_++];
  span.q = p.kind == PrimitiveKind::line ? p.direction : Vec3{};
  span.s = p.strength_n, span.gamma = detail::gamma_of(p, k_, step_.time_step_s);
  span.index = static_cast<std::uint32_t>(i);
  span.u = shortened(span.across(warm_n), span.gamma > 0.0 ? std::numeric_limits<double>::infinity() : span.s);
  span.foot = foot_of(p, step_), span.gain = feet_[span.foot].gain;
  strongest_n_ = std::max(strongest_n_, span.s);
}

void PoseSolver::Work::pose_corner(std::size_t first, std::size_t facets, const Vec3* warm_n) noexcept {
  AtFoot<Corner>& corner = corner_[corners_++];
  corner.foot = foot_of(primitives_[first], step_), corner.gain = feet_[corner.foot].gain;
  corner.normals = {&normals_[facets_], facets};
  corner.b = &offsets_n_[facets_];
  corner.s = primitives_[first].strength_n;
  corner.compliance = detail::compliance_of(primitives_[first], k_);
  corner.rest = rest_of_spring(corner.compliance);
  corner.index = static_cast<std::uint32_t>(first);
  corner.face.size = 0;
  for (std::size_t i = 0; i < facets; ++i) {
    const Vec3& normal = normals_[facets_++] = primitives_[first + i].direction;
    const double t = dot(normal, warm_n[first + i]);
    if (t > 0.0 && corner.face.take(static_cast<int>(i), normal)) corner.t[corner.face.size - 1] = t;
  }
  corner.gather(false);
  strongest_n_ = std::max(strongest_n_, corner.s);
}

namespace {

// Component of the distance from a foot to an anchor. The foot is displaced by `o_m` and by a component of arc × β, whose β is
// off by a rounding: `turned_rest`.
detail::Double2 component(double anchor_m, double foot_m, double o_m, double arc_a, double beta_a, double arc_b, double beta_b,
                          double turned_rest) noexcept {
  using detail::two_product, detail::two_sum;
  detail::Double2 turned = detail::sum(two_product(arc_a, beta_a), two_product(-arc_b, beta_b));
  turned = detail::sum(turned, {o_m, 0.0});
  turned = detail::sum(turned, {turned_rest, 0.0});
  return detail::sum(two_sum(anchor_m, -foot_m), {-turned.high, -turned.low});
}

// b − βρ of a component.
double rest_of(double b_m, double radius_m, double beta) noexcept {
  const detail::Double2 product = detail::two_product(beta, radius_m);
  return (b_m - product.high) - product.low;
}

struct Distance {
  detail::Double2 x, y, z;
};
Distance distance_to(const Vec3& a, const Foot& foot, const Six& o, double radius_m) noexcept {
  const Vec3 &f = foot.start_m, &b = foot.beta, &lever_m = foot.lever_m;
  const Vec3 rest = cross(
      o.arc,
      Vec3{rest_of(lever_m.x, radius_m, b.x), rest_of(lever_m.y, radius_m, b.y), rest_of(lever_m.z, radius_m, b.z)} / radius_m);
  return {component(a.x, f.x, o.way.x, o.arc.y, b.z, o.arc.z, b.y, rest.x),
          component(a.y, f.y, o.way.y, o.arc.z, b.x, o.arc.x, b.z, rest.y),
          component(a.z, f.z, o.way.z, o.arc.x, b.y, o.arc.y, b.x, rest.z)};
}

// Size of the terms of k (a − o), o being the displacement of the foot at the origin with its own rounding and that of β.
double size_of_anchor(const Vec3& offset_m, const Six& o, const Foot& foot) noexcept {
  return size_of(offset_m) + size_of(o.way) + 3.0 * size_of(o.arc) * foot.size;
}

detail::Slide slide_from(const Foot& foot, const Six& origin_m, double radius_m, const Vec3& q, const Vec3& a) noexcept {
  const Distance d = distance_to(a, foot, origin_m, radius_m);
  return detail::slide(q, d.x, d.y, d.z);
}

}  // namespace

// Anchors relative to the foot, displaced by the origin. Rounding of B shifts the anchor: where that would show in the bound,
// with its root, the difference and its component along q are computed in double-double.
bool PoseSolver::Work::is_at_origin(const Primitive& primitive, const Foot& foot) const noexcept {
  return primitive.position_m == foot.start_m && origin_m_.way == Vec3{} && origin_m_.arc == Vec3{};
}

void PoseSolver::Work::anchor(AtFoot<Plane>& p) const noexcept {
  const Primitive& primitive = primitives_[p.index];
  const Foot& foot = feet_[p.foot];
  p.b = p.size = 0.0;
  if (is_at_origin(primitive, foot)) return;
  const Vec3 offset_m = primitive.position_m - foot.start_m, o_m = at_foot(origin_m_, foot.beta);
  const Vec3 B = k_ * (offset_m - o_m);
  p.b = dot(p.q, B);
  p.size = k_ * size_of_anchor(offset_m, origin_m_, foot);
  if (precise_ || p.s * p.size * epsilon > shown_n2_) {
    p.b = k_ * slide_from(foot, origin_m_, step_.turning_radius_m, p.q, primitive.position_m).along;
    p.size = std::abs(p.b);
  }
}

void PoseSolver::Work::anchor(FootSpan& p) const noexcept {
  const Primitive& primitive = primitives_[p.index];
  const Foot& foot = feet_[p.foot];
  p.B = {}, p.size = 0.0;
  if (is_at_origin(primitive, foot)) return;
  const Vec3 offset_m = primitive.position_m - foot.start_m, o_m = at_foot(origin_m_, foot.beta);
  p.B = p.across(k_ * (offset_m - o_m));
  p.size = k_ * size_of_anchor(offset_m, origin_m_, foot);
  if (precise_ || p.s * p.size * epsilon > shown_n2_) {
    p.B = k_ * slide_from(foot, origin_m_, step_.turning_radius_m, p.q, primitive.position_m).across;
    p.size = size_of(p.B);
  }
}

void PoseSolver::Work::anchor(const AtFoot<Corner>& corner) noexcept {
  double* const b = &offsets_n_[static_cast<std::size_t>(corner.b - offsets_n_.get())];
  for (std::size_t i = 0; i < corner.normals.size(); ++i) {
    const Vec3& a = primitives_[corner.index + i].position_m;
    b[i] = k_ * slide_from(feet_[corner.foot], origin_m_, step_.turning_radius_m, corner.normals[i], a).along;
  }
}

void PoseSolver::Work::anchor_all() noexcept {
  const Six back_n = k_ * origin_m_;
  C_ = way_n_ - back_n + directed_n_;
  // The last term is the rounding of the rotation vector between the turns.
  C_size_ = 2.0 * size_of(way_n_) + 2.0 * size_of(back_n) + directed_size_n_ + 2.0 * k_ * step_.turning_radius_m;
  anchored_precisely_ = precise_;
  rows_ += 8 * static_cast<int>(size());
  for (std::size_t i = 0; i < planes_; ++i) anchor(plane_[i]);
  for (std::size_t i = 0; i < spans_; ++i) anchor(span_[i]);
  for (std::size_t i = 0; i < corners_; ++i) anchor(corner_[i]);
}

// Moves the origin to the tool. Residuals of primitives that a foot rests on are then differences of nearby doubles.
void PoseSolver::Work::recentre() noexcept {
  const Six z_m = by_k_ * Z_;
  const Six origin_m = origin_m_ + z_m;
  Z_ = k_ * ((origin_m_ - origin_m) + z_m);
  origin_m_ = origin_m;
  anchor_all();
}

// Whether rounding at this distance from the origin would show in the bound.
bool PoseSolver::Work::is_recentring_shown() const noexcept {
  if (precise_ != anchored_precisely_ || corners_ > 0) return true;
  double size = 0.0;
  for (std::size_t f = 0; f < feet_count_; ++f) size = std::max(size, feet_[f].size);
  return strongest_n_ * detail::plane_rounding * (size_of(Z_.way) + size_of(Z_.arc) * (1.0 + size)) > shown_n2_;
}

// Sets J Z of all feet.
void PoseSolver::Work::look() noexcept {
  for (std::size_t f = 0; f < feet_count_; ++f) feet_[f].Z = at_foot(Z_, feet_[f].beta);
}

// Wrench of all forces.
Six PoseSolver::Work::gathered() noexcept {
  for (std::size_t f = 0; f < feet_count_; ++f) feet_[f].u = {};
  for (std::size_t i = 0; i < planes_; ++i) feet_[plane_[i].foot].u += plane_[i].t * plane_[i].q;
  for (std::size_t i = 0; i < spans_; ++i) feet_[span_[i].foot].u += span_[i].u;
  for (std::size_t i = 0; i < corners_; ++i) feet_[corner_[i].foot].u += corner_[i].u;
  Six all;
  for (std::size_t f = 0; f < feet_count_; ++f) all += wrench(feet_[f].u, feet_[f].beta);
  return all;
}

// Z at which these forces balance.
Six PoseSolver::Work::sum() noexcept { return C_ + gathered(); }

double PoseSolver::Work::bound_of(double left_n, double gap_n2) noexcept {
  return 0.5 * (left_n + std::sqrt(left_n * left_n + 4.0 * gap_n2));
}

namespace {

// Gap of a corner whose foot's Z is off by `off`: about an origin so far away that rounding there is as large.
detail::Gap gap_at(const Corner& corner, const Vec3& Z, double off) noexcept {
  if (off == 0.0) return gap(corner, Z);
  double b[most_facets];
  Corner moved = corner;
  moved.b = b;
  const double away = off / epsilon;
  for (std::size_t i = 0; i < corner.normals.size(); ++i) b[i] = corner.b[i] + away * corner.normals[i].x;
  return gap(moved, Z + Vec3{away, 0.0, 0.0});
}

}  // namespace

// Bound of the iterate by docs/theory.md 10.2.
PoseSolver::Work::Proven PoseSolver::Work::prove() noexcept {
  look();
  count();
  double plain = 0.0, rounded = 0.0, slack = 0.0, size = size_of(Z_) + C_size_, terms = directed_terms_ + 1.0;
  // J Z is off by its own rounding and that of β.
  const auto off_n = [&](const Foot& foot) {
    return foot.size > 0.0 ? epsilon * (size_of(foot.Z) + 3.0 * size_of(Z_.arc) * foot.size) : 0.0;
  };
  const auto add = [&](const detail::Gap& gap, const Vec3& u, const Foot& foot) {
    plain += gap.plain;
    rounded += gap.rounded;
    slack += gap.slack * (1.0 + foot.size);
    size += size_of(u) * (1.0 + 2.0 * foot.size);
    terms += 1.0;
  };
  for (std::size_t i = 0; i < planes_; ++i) {
    const AtFoot<Plane>& p = plane_[i];
    const Foot& foot = feet_[p.foot];
    add(gap(p, foot.Z, size_of(foot.Z) + off_n(foot) / detail::plane_rounding), p.t * p.q, foot);
  }
  for (std::size_t i = 0; i < spans_; ++i) {
    FootSpan& p = span_[i];
    const Foot& foot = feet_[p.foot];
    const double size_of_anchor = p.size;
    p.size += off_n(foot) / detail::span_rounding;
    add(gap(p, foot.Z), p.u, foot);
    p.size = size_of_anchor;
  }
  for (std::size_t i = 0; i < corners_; ++i) {
    const Foot& foot = feet_[corner_[i].foot];
    add(gap_at(corner_[i], foot.Z, off_n(foot)), corner_[i].u, foot);
  }
  const Six left = Z_ - C_ - gathered();
  Proven proven;
  proven.left_n = std::hypot(norm(left.way), norm(left.arc));
  proven.rounding_n = (8.0 + terms) * epsilon * size + 1e-140;
  proven.plain_n = bound_of(proven.left_n, plain);
  proven.all_left_n = proven.left_n + slack + proven.rounding_n;
  proven.gap_n2 = rounded;
  proven.share = 1.0 + (8.0 + terms) * epsilon;
  proven.bound_n = bound_of(proven.all_left_n, rounded) * proven.share;
  return proven;
}

// Whether the iterate is good enough; stores it if its bound is the best so far. See Solver::Work::certify for the acceptance.
bool PoseSolver::Work::certify(int stage) noexcept {
  const Proven iterate = prove();
  bound_n_ = iterate.bound_n;
  bool proven = bound_n_ <= wanted_n_;
  if (!proven && iterate.plain_n <= 0.5 * wanted_n_) {
    proven = bound_n_ <= 4.0 * wanted_n_ || anchored_precisely_;
    precise_ = true;
  }
  const bool done = proven && iterate.left_n <= seen_share * wanted_n_ + iterate.rounding_n;
  if (done || bound_n_ < best_bound_n_) {
    best_bound_n_ = bound_n_;
    best_left_n_ = iterate.all_left_n, best_gap_n2_ = iterate.gap_n2, best_share_ = iterate.share;
    best_m_ = origin_m_ + by_k_ * Z_;
    best_rest_n_ = Z_ - k_ * (best_m_ - origin_m_);
    best_stage_ = stage;
    for (std::size_t i = 0; i < planes_; ++i) best_forces_n_[plane_[i].index] = plane_[i].t * plane_[i].q;
    for (std::size_t i = 0; i < spans_; ++i) best_forces_n_[span_[i].index] = span_[i].across(span_[i].u);
    for (std::size_t i = 0; i < corners_; ++i) corner_[i].give(best_forces_n_.get());
  }
  return done;
}

void PoseSolver::Work::give(Balance& balance, Vec3* forces_n) noexcept {
  const bool any = best_bound_n_ < std::numeric_limits<double>::max();
  bool free = true;
  for (std::size_t i = 0; i < primitives_.size(); ++i) {
    const Primitive& p = primitives_[i];
    forces_n[i] = p.kind == PrimitiveKind::directed ? p.strength_n * p.direction : any ? best_forces_n_[i] : Vec3{};
    free = free && forces_n[i] == Vec3{};
  }
  // In free space the tool is at the device, to the bit: the damper detects free space by that.
  const Vec3& start_m = step_.start.position_m;
  balance.position_m = free && any ? step_.probe.position_m : start_m + best_m_.way;
  balance.way_m = free && any ? step_.probe.position_m - start_m : best_m_.way;
  balance.turn_rad =
      free && any ? rotation_between_rad(step_.start.turn, step_.probe.turn) : best_m_.arc / step_.turning_radius_m;
  const Vec3 remainder_m = (start_m - balance.position_m) + best_m_.way;
  const double bound_m = best_bound_n_ * by_k_ * (1.0 + 2.0 * epsilon) + by_k_ * size_of(best_rest_n_) + size_of(remainder_m) +
                         4.0 * epsilon * size_of(best_m_);
  balance.error_bound_m = bound_m < std::numeric_limits<double>::max() ? bound_m : std::numeric_limits<double>::max();
  balance.status = balance.error_bound_m <= exact_bound_m ? BalanceStatus::exact : BalanceStatus::capped;
  balance.stage = best_stage_;
  balance.iterations = iterations_;
}

double PoseSolver::Work::bound_m(const Motion& at) noexcept {
  // About the place itself, in double-double: Z = 0.
  precise_ = true;
  origin_m_ = {at.way_m, at.arc_m};
  Z_ = {};
  anchor_all();
  const double bound = prove().bound_n * by_k_ * (1.0 + 2.0 * epsilon) + 4.0 * epsilon * size_of(origin_m_);
  return std::isfinite(bound) ? bound : std::numeric_limits<double>::max();
}

void PoseSolver::Work::keep() noexcept {
  kept_Z_ = Z_;
  for (std::size_t i = 0; i < planes_; ++i) kept_planes_n_[i] = plane_[i].t;
  for (std::size_t i = 0; i < spans_; ++i) kept_spans_n_[i] = span_[i].u;
  for (std::size_t i = 0; i < corners_; ++i) kept_corners_[i] = corner_[i];
}

void PoseSolver::Work::restore() noexcept {
  Z_ = kept_Z_;
  for (std::size_t i = 0; i < planes_; ++i) plane_[i].t = kept_planes_n_[i];
  for (std::size_t i = 0; i < spans_; ++i) span_[i].u = kept_spans_n_[i];
  for (std::size_t i = 0; i < corners_; ++i) static_cast<Corner&>(corner_[i]) = kept_corners_[i];
}

}  // namespace palpa
