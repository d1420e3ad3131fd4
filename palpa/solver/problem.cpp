// Poses a problem in newtons, and proves iterates.
#include "palpa/solver/solver_work.h"

namespace palpa {

using namespace detail::solving;

inline std::size_t Solver::Work::begin(std::span<const Primitive> primitives, const Vec3& start_m, const Vec3& probe_m,
                                       double k) noexcept {
  primitives_ = primitives;
  start_m_ = start_m, probe_m_ = probe_m;
  k_ = k, by_k_ = 1.0 / k;
  wanted_n_ = k * wanted_bound_m;
  balanced_n_ = refined_share * wanted_n_;
  // [1] Rounding of an anchor counts by its root: a tenth may cost √0.1 of the target bound. Less: more double-double anchors,
  // which are slower; more: rounding of anchors spoils bounds.
  shown_n2_ = 0.1 * wanted_n_ * wanted_n_;
  precise_ = anchored_precisely_ = false;
  best_bound_n_ = std::numeric_limits<double>::max();
  best_origin_m_ = start_m, best_Z_ = {};
  done_ = false;
  iterations_ = 0;

  directed_n_ = {};
  directed_size_n_ = directed_terms_ = 0.0;
  std::size_t points = 0;
  line_count_ = 0;
  for (const Primitive& p : primitives) {
    points += p.kind == PrimitiveKind::point, line_count_ += p.kind == PrimitiveKind::line;
    if (p.kind != PrimitiveKind::directed) continue;
    directed_n_ += p.strength_n * p.direction;
    directed_size_n_ += 2.0 * p.strength_n;
    directed_terms_ += 1.0;
  }
  all_spans_ = line_count_ + points;
  return points;
}

void Solver::Work::pose(std::span<const Primitive> primitives, const Vec3* warm_n, const Vec3& start_m, const Vec3& probe_m,
                        double k, double T) noexcept {
  common_ = begin(primitives, start_m, probe_m, k) > 0;
  // About the start: primitives placed there, as modes do, get B = 0 exactly.
  origin_m_ = start_m;
  const Vec3 way_n = k * (probe_m - start_m);
  C_ = way_n + directed_n_;
  C_size_ = 2.0 * size_of(way_n) + directed_size_n_;
  plane_count_ = corner_count_ = facet_count_ = 0;
  std::size_t line = 0, point = line_count_;
  const Vec3* first_m = nullptr;
  warm_ = false;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    const double gamma = detail::gamma_of(p, k, T);
    if (!first_m) first_m = &p.position_m;
    common_ = common_ && p.position_m == *first_m && (gamma == 0.0 || p.kind == PrimitiveKind::point) && !p.is_elastic();
    const double longest = gamma > 0.0 ? std::numeric_limits<double>::infinity() : p.strength_n;
    if (p.kind == PrimitiveKind::corner) {
      const std::span<const Primitive> facets = whole_of(primitives, i);
      for (const Primitive& facet : facets) common_ = common_ && facet.position_m == *first_m;
      if (facets.size() > 1) {
        pose_corner(i, facets.size(), warm_n);
        i += facets.size() - 1;
        continue;
      }
    }
    if (p.kind == PrimitiveKind::plane || p.kind == PrimitiveKind::corner) {
      Plane& plane = planes_[plane_count_++];
      plane.q = p.direction, plane.s = p.strength_n, plane.gamma = gamma, plane.index = static_cast<std::uint32_t>(i);
      plane.compliance = detail::compliance_of(p, k);
      plane.rest = rest_of_spring(plane.compliance);
      plane.t = std::clamp(dot(p.direction, warm_n[i]), 0.0, longest);
      warm_ = warm_ || plane.t > 0.0;
      anchor(plane);
    } else {
      Span& span = spans_[p.kind == PrimitiveKind::line ? line++ : point++];
      span.q = p.direction, span.s = p.strength_n, span.gamma = gamma, span.index = static_cast<std::uint32_t>(i);
      span.u = span.across(warm_n[i]);
      if (norm_squared(span.u) > longest * longest) span.u = shortened(span.u, longest);
      warm_ = warm_ || span.u != Vec3{};
      anchor(span);
    }
  }
  common_ = common_ && plane_count_ + line_count_ + corner_count_ > 0;
  span_count_ = common_ ? line_count_ : all_spans_;
}

void Solver::Work::pose_corner(std::size_t first, std::size_t facets, const Vec3* warm_n) noexcept {
  Corner& corner = corners_[corner_count_++];
  corner.normals = {&normals_[facet_count_], facets};
  corner.b = &offsets_n_[facet_count_];
  corner.s = primitives_[first].strength_n;
  corner.compliance = detail::compliance_of(primitives_[first], k_);
  corner.rest = rest_of_spring(corner.compliance);
  corner.index = static_cast<std::uint32_t>(first);
  corner.face.size = 0;
  corner.u = {};
  for (std::size_t i = first; i < first + facets; ++i) {
    normals_[facet_count_++] = primitives_[i].direction;
    corner.u += std::max(0.0, dot(primitives_[i].direction, warm_n[i])) * primitives_[i].direction;
  }
  corner.u = shortened(corner.u, corner.s);
  warm_ = warm_ || corner.u != Vec3{};
  anchor(corner);
}

// Anchors relative to the origin. Rounding of B shifts the anchor: where the proxy rests with strength s it costs √(s|shift|)
// in the bound, so where that would show, the difference and its component along q are computed in double-double.
void Solver::Work::anchor(Plane& p) const noexcept {
  const Vec3& a = primitives_[p.index].position_m;
  if (a == origin_m_) {
    p.b = p.size = 0.0;
    return;
  }
  const Vec3 B = k_ * (a - origin_m_);
  p.b = dot(p.q, B);
  p.size = size_of(B);
  if (precise_ || p.s * p.size * epsilon > shown_n2_) {
    p.b = k_ * detail::slide(p.q, a, origin_m_).along;
    p.size = std::abs(p.b);
  }
}

void Solver::Work::anchor(Span& p) const noexcept {
  const Primitive& primitive = primitives_[p.index];
  if (primitive.position_m == origin_m_) {
    p.B = {}, p.size = 0.0;
    return;
  }
  p.B = k_ * (primitive.position_m - origin_m_);
  p.size = size_of(p.B);
  if (primitive.kind == PrimitiveKind::point) return;
  if (precise_ || p.s * p.size * epsilon > shown_n2_) {
    p.B = k_ * detail::slide(p.q, primitive.position_m, origin_m_).across;
    p.size = size_of(p.B);
  } else {
    p.B = p.across(p.B);
  }
}

// A shift of a facet shifts its edges, by the inverse of their angle: always double-double.
void Solver::Work::anchor(const Corner& corner) noexcept {
  double* const b = &offsets_n_[static_cast<std::size_t>(corner.b - offsets_n_.get())];
  for (std::size_t i = 0; i < corner.normals.size(); ++i) {
    b[i] = k_ * detail::slide(corner.normals[i], primitives_[corner.index + i].position_m, origin_m_).along;
  }
}

// Moves the origin to the proxy. Residuals of primitives that the proxy rests on are then differences of nearby doubles: exact
// where rounding would be multiplied by τ or stand under a root.
void Solver::Work::recentre() noexcept {
  const Vec3 z_m = by_k_ * Z_;
  const Vec3 origin_m = origin_m_ + z_m;
  Z_ = k_ * ((origin_m_ - origin_m) + z_m);
  origin_m_ = origin_m;
  const Vec3 way_n = k_ * (probe_m_ - origin_m);
  C_ = way_n + directed_n_;
  C_size_ = 2.0 * size_of(way_n) + directed_size_n_;
  anchored_precisely_ = precise_;
  for (std::size_t i = 0; i < plane_count_; ++i) anchor(planes_[i]);
  for (std::size_t i = 0; i < all_spans_; ++i) anchor(spans_[i]);
  for (std::size_t i = 0; i < corner_count_; ++i) anchor(corners_[i]);
}

// Z at which these forces balance.
Vec3 Solver::Work::sum() const noexcept {
  Vec3 sum = C_;
  for (std::size_t i = 0; i < plane_count_; ++i) sum += planes_[i].t * planes_[i].q;
  for (std::size_t i = 0; i < span_count_; ++i) sum += spans_[i].u;
  for (std::size_t i = 0; i < corner_count_; ++i) sum += corners_[i].u;
  return sum;
}

// Whether the iterate is good enough; stores it if its bound is the best so far.
bool Solver::Work::certify(int stage) noexcept {
  const Vec3 rest = Z_;
  if (common_) add_common_points();

  Proof proof(Z_, C_, C_size_, directed_terms_ + 1.0);
  const double size_of_Z = size_of(Z_);
  for (std::size_t i = 0; i < plane_count_; ++i) proof.add(gap(planes_[i], Z_, size_of_Z), planes_[i].t * planes_[i].q);
  for (std::size_t i = 0; i < span_count_; ++i) proof.add(gap(spans_[i], Z_), spans_[i].u);
  for (std::size_t i = 0; i < corner_count_; ++i) proof.add(gap(corners_[i], Z_), corners_[i].u);
  ++iterations_;

  const double bound_n = proof.bound();
  const double plain_n = proof.plain_bound();
  bool proven = bound_n <= wanted_n_;
  if (!proven && plain_n <= 0.5 * wanted_n_) {
    // Without rounding the bound would be small enough, with room: anchors are double-double from here on. Four times the
    // target bound is accepted, which still is below `exact_bound_m` (more: `exact` would be a false claim; less: more rounds
    // for rounding alone), and any bound if the precision is exhausted. Half: more blames rounding wrongly; less uses
    // double-double late.
    proven = bound_n <= 4.0 * wanted_n_ || anchored_precisely_;
    precise_ = true;
  }
  // A residual force costs little in the bound, but is visible in a sum of the forces.
  const bool done = proven && proof.left() <= seen_share * wanted_n_ + proof.rounding();

  done_ = done;
  if (done || bound_n < best_bound_n_) {
    best_bound_n_ = bound_n;
    best_origin_m_ = origin_m_, best_Z_ = Z_;
    best_stage_ = stage;
    if (!done) {
      for (std::size_t i = 0; i < plane_count_; ++i) best_forces_n_[planes_[i].index] = planes_[i].t * planes_[i].q;
      for (std::size_t i = 0; i < span_count_; ++i) best_forces_n_[spans_[i].index] = spans_[i].u;
      for (std::size_t i = 0; i < corner_count_; ++i) corners_[i].give(best_forces_n_.get());
    }
  }
  if (common_ && !done) {
    // This near, rounding matters: it is least with the origin at the balance of all, not at that without the points.
    common_ = plain_n > near_share * wanted_n_;
    if (common_) span_count_ = line_count_, Z_ = rest;
  }
  return done;
}

void Solver::Work::keep() noexcept {
  kept_Z_ = Z_;
  for (std::size_t i = 0; i < plane_count_; ++i) kept_planes_n_[i] = planes_[i].t;
  for (std::size_t i = 0; i < all_spans_; ++i) kept_spans_n_[i] = spans_[i].u;
  std::copy_n(corners_.get(), corner_count_, kept_corners_.get());
}

void Solver::Work::restore() noexcept {
  Z_ = kept_Z_;
  for (std::size_t i = 0; i < plane_count_; ++i) planes_[i].t = kept_planes_n_[i];
  for (std::size_t i = 0; i < all_spans_; ++i) spans_[i].u = kept_spans_n_[i];
  std::copy_n(kept_corners_.get(), corner_count_, corners_.get());
}

// Whether an error `off_n` of a residual shows in the bound, by its root: with the strength of a force, and of a drag with its
// unbounded stiffness.
bool Solver::Work::shows_in_gap(double off_n, double longest_n, double gamma) const noexcept {
  return !(off_n * (longest_n + gamma * off_n) <= shown_by_root * wanted_n_ * wanted_n_);
}

void Solver::Work::give(Balance& balance, Vec3& remainder_m, Vec3* forces_n) noexcept {
  if (done_) {
    for (std::size_t i = 0; i < plane_count_; ++i) forces_n[planes_[i].index] = planes_[i].t * planes_[i].q;
    for (std::size_t i = 0; i < all_spans_; ++i) forces_n[spans_[i].index] = spans_[i].across(spans_[i].u);
    for (std::size_t i = 0; i < corner_count_; ++i) corners_[i].give(forces_n);
  }
  const bool any = best_bound_n_ < std::numeric_limits<double>::max();
  bool free = true;
  for (std::size_t i = 0; i < primitives_.size(); ++i) {
    if (primitives_[i].kind == PrimitiveKind::directed) {
      forces_n[i] = primitives_[i].strength_n * primitives_[i].direction;
    } else if (!done_) {
      forces_n[i] = any ? best_forces_n_[i] : Vec3{};
    }
    free = free && forces_n[i] == Vec3{};
  }
  const Vec3 z_m = by_k_ * best_Z_;
  // In free space the proxy is the probe, to the bit: the damper detects free space by that.
  balance.position_m = free && any ? probe_m_ : best_origin_m_ + z_m;
  moved_m_ = balance.position_m - start_m_;
  remainder_m = (best_origin_m_ - balance.position_m) + z_m;
  // The last term is for by_k_ and for the remainder, which rounds where the proxy is far from the origin.
  const double bound_m = best_bound_n_ * by_k_ * (1.0 + 2.0 * epsilon) + size_of(remainder_m) + 2.0 * epsilon * size_of(z_m);
  balance.error_bound_m = bound_m < std::numeric_limits<double>::max() ? bound_m : std::numeric_limits<double>::max();
  balance.status = balance.error_bound_m <= exact_bound_m ? BalanceStatus::exact : BalanceStatus::capped;
  balance.stage = best_stage_;
  balance.iterations = iterations_;
}

Solver::Solver(std::size_t capacity)
    : capacity_(capacity),
      forces_(std::make_unique<Vec3[]>(capacity)),
      ids_(std::make_unique<PrimitiveId[]>(capacity)),
      work_(std::make_unique<Work>(capacity)) {}

Solver::~Solver() = default;

}  // namespace palpa
