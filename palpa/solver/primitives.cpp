#include "palpa/solver/primitives.h"

#include <cassert>
#include <limits>

#include "palpa/solver/corner.h"

namespace palpa {

namespace {

// A direction counts as unit if its length is 1 to within the rounding of a normalisation; off by 1e-6 it would already shift
// forces. Less: normalised directions are refused; more: forces shift.
constexpr double unit_tolerance = 1e-12;

// Tolerance for a drag's residual at the start: the rounding of placing the primitive at the proxy, at any workspace size.
// Less: rounding refuses drags; more: a drag could act as a spring.
constexpr double start_tolerance_m = 1e-14;

bool is_usable(const Vec3& position_m) noexcept { return is_within(position_m, largest_position_m); }

bool is_unit(const Vec3& q) noexcept { return std::abs(norm_squared(q) - 1.0) <= 2.0 * unit_tolerance; }

// Normalises a direction within the tolerance to rounding, as the solver's bound requires; exact directions keep their bits.
Vec3 unit_to_rounding(const Vec3& q) noexcept {
  const double off = norm_squared(q) - 1.0;
  return std::abs(off) <= 4.0 * std::numeric_limits<double>::epsilon() ? q : (1.0 - 0.5 * off) * q;
}

// Primitives of a mode at a foot are placed one after the other.
bool is_beside(const PrimitiveId& a, const PrimitiveId& b) noexcept { return a.mode == b.mode && a.foot == b.foot; }

}  // namespace

const char* name_of(PrimitiveKind kind) noexcept {
  switch (kind) {
    case PrimitiveKind::point: return "point";
    case PrimitiveKind::line: return "line";
    case PrimitiveKind::plane: return "plane";
    case PrimitiveKind::directed: return "directed";
    case PrimitiveKind::corner: return "facet";
  }
  return "?";
}

const char* name_of(PrimitiveState state) noexcept {
  switch (state) {
    case PrimitiveState::stick: return "stick";
    case PrimitiveState::slip: return "slip";
    case PrimitiveState::off: return "off";
  }
  return "?";
}

const char* sentence_of(Refusal refusal) noexcept {
  switch (refusal) {
    case Refusal::position_not_finite: return "position is not finite or beyond 1e6 m";
    case Refusal::direction_not_unit: return "direction is not of unit length";
    case Refusal::strength_not_finite: return "strength is not finite or above 1e9 N";
    case Refusal::strength_negative: return "strength is negative";
    case Refusal::drag_not_finite: return "drag is not finite or above 1e9 N s/m";
    case Refusal::drag_negative: return "drag is negative";
    case Refusal::drag_away_from_start: return "drag is placed away from the start of the sub-step";
    case Refusal::slot_used_twice: return "slot is used twice";
    case Refusal::stiffness_not_positive: return "stiffness is not above 1e-12 N/m";
    case Refusal::elastic_without_plane: return "stiffness is of what is no plane";
    case Refusal::elastic_with_drag: return "stiffness is of a plane with drag";
    case Refusal::friction_without_plane: return "friction names no plane of its mode";
    case Refusal::facet_without_plane: return "facet belongs to no plane";
    case Refusal::facet_with_drag: return "facet is of a corner with drag";
    case Refusal::facets_full: return "corner has eight facets already";
    case Refusal::corner_too_narrow: return "corner is narrower than 0.12 degrees";
    case Refusal::full: return "the set of primitives is full";
  }
  return "?";
}

Vec3 residual(const Primitive& primitive, const Vec3& x_m) noexcept {
  const Vec3 r = primitive.position_m - x_m;
  const Vec3& q = primitive.direction;
  switch (primitive.kind) {
    case PrimitiveKind::point: return r;
    case PrimitiveKind::line: return r - dot(q, r) * q;
    case PrimitiveKind::plane:
    case PrimitiveKind::corner: return std::max(0.0, dot(q, r)) * q;
    case PrimitiveKind::directed: return {};
  }
  return {};
}

std::span<const Primitive> whole_of(std::span<const Primitive> primitives, std::size_t i) noexcept {
  if (primitives[i].kind != PrimitiveKind::corner) return primitives.subspan(i, 1);
  const auto is_facet_beside = [&](std::size_t j) {
    const Primitive &a = primitives[i], &b = primitives[j];
    return a.kind == PrimitiveKind::corner && b.kind == a.kind && b.id == a.id && b.strength_n == a.strength_n &&
           b.stiffness_n_per_m == a.stiffness_n_per_m;
  };
  std::size_t first = i, end = i + 1;
  while (first > 0 && is_facet_beside(first - 1)) --first;
  while (end < primitives.size() && is_facet_beside(end)) ++end;
  return primitives.subspan(first, end - first);
}

Vec3 residual(std::span<const Primitive> primitives, std::size_t i, const Vec3& x_m) noexcept {
  const std::span<const Primitive> whole = whole_of(primitives, i);
  return whole.size() > 1 && whole.size() <= most_facets ? detail::way_out(whole, x_m) : residual(primitives[i], x_m);
}

Vec3 way_to_footing_m(std::span<const Primitive> primitives, std::size_t i, const Vec3& x_m) noexcept {
  const Vec3 offset_m = residual(primitives, i, x_m);
  const double longest_m = primitives[i].strength_n / primitives[i].stiffness_n_per_m;
  return std::min(1.0, longest_m / norm(offset_m)) * offset_m;
}

PrimitiveSet::PrimitiveSet(std::size_t capacity)
    : capacity_(capacity),
      primitives_(std::make_unique<Primitive[]>(capacity)),
      captured_(std::make_unique<HeldLevel[]>(capacity)),
      friction_(std::make_unique<Friction[]>(capacity)),
      rows_(std::make_unique<std::size_t[]>(capacity)) {
  assert(capacity > 0);
}

void PrimitiveSet::clear(const Vec3& start_m) noexcept {
  size_ = facets_ = 0;
  start_m_ = start_m;
  begin_foot(0, start_m);
  mode_ = 0;
  refused_size_ = 0;
  dropped_ = 0;
}

void PrimitiveSet::point(std::uint16_t slot, const Vec3& position_m, double strength_n, double drag_ns_per_m) noexcept {
  add({PrimitiveKind::point, id_of(slot), position_m, {}, strength_n, drag_ns_per_m});
}

void PrimitiveSet::line(std::uint16_t slot, const Vec3& position_m, const Vec3& direction, double strength_n,
                        double drag_ns_per_m) noexcept {
  add({PrimitiveKind::line, id_of(slot), position_m, direction, strength_n, drag_ns_per_m});
}

void PrimitiveSet::plane(std::uint16_t slot, const Vec3& position_m, const Vec3& normal, double strength_n,
                         const HeldLevel& captured, double drag_ns_per_m) noexcept {
  add({PrimitiveKind::plane, id_of(slot), position_m, normal, strength_n, drag_ns_per_m}, captured);
}

void PrimitiveSet::elastic_plane(std::uint16_t slot, const Vec3& position_m, const Vec3& normal, double strength_n,
                                 double stiffness_n_per_m, const HeldLevel& captured) noexcept {
  add({PrimitiveKind::plane, id_of(slot), position_m, normal, strength_n, 0.0, stiffness_n_per_m}, captured);
}

void PrimitiveSet::directed(std::uint16_t slot, const Vec3& direction, double strength_n) noexcept {
  add({PrimitiveKind::directed, id_of(slot), {}, direction, strength_n, 0.0});
}

void PrimitiveSet::friction(std::uint16_t slot, std::uint16_t plane_slot, const Vec3& position_m, double coefficient,
                            double drag_ns_per_m) noexcept {
  const PrimitiveId plane_id = id_of(plane_slot);
  for (std::size_t handle = 0; handle < size_ - facets_; ++handle) {
    const Primitive& plane = primitives_[row(handle)];
    if (plane.id == plane_id && (plane.kind == PrimitiveKind::plane || plane.kind == PrimitiveKind::corner)) {
      // The strength follows from the plane's force; the coefficient is checked in its place.
      Primitive line{PrimitiveKind::line, id_of(slot), position_m, plane.direction, coefficient, drag_ns_per_m};
      add(line, {}, {static_cast<std::int32_t>(handle), coefficient});
      return;
    }
  }
  refuse(id_of(slot), Refusal::friction_without_plane);
}

void PrimitiveSet::take(Primitive& p, const HeldLevel& captured, const Friction& friction) noexcept {
  p.id.mode = mode_, p.id.foot = foot_;
  if (!(std::abs(p.strength_n) <= largest_strength_n)) return refuse(p.id, Refusal::strength_not_finite);
  if (p.strength_n < 0.0) return refuse(p.id, Refusal::strength_negative);
  if (!(std::abs(p.drag_ns_per_m) <= largest_drag_ns_per_m)) return refuse(p.id, Refusal::drag_not_finite);
  if (p.drag_ns_per_m < 0.0) return refuse(p.id, Refusal::drag_negative);
  if (!(p.stiffness_n_per_m >= softest_level_n_per_m)) return refuse(p.id, Refusal::stiffness_not_positive);
  if (p.is_elastic()) {
    if (p.kind != PrimitiveKind::plane && p.kind != PrimitiveKind::corner) return refuse(p.id, Refusal::elastic_without_plane);
    if (p.drag_ns_per_m > 0.0) return refuse(p.id, Refusal::elastic_with_drag);
  }
  if (p.kind == PrimitiveKind::directed) {
    p.position_m = {};
  } else if (!is_usable(p.position_m)) {
    return refuse(p.id, Refusal::position_not_finite);
  }
  if (p.kind == PrimitiveKind::point) {
    p.direction = {};
  } else if (!is_unit(p.direction)) {
    return refuse(p.id, Refusal::direction_not_unit);
  } else {
    p.direction = unit_to_rounding(p.direction);
  }
  if (p.drag_ns_per_m > 0.0) {
    if (p.kind == PrimitiveKind::corner) return refuse(p.id, Refusal::facet_with_drag);
    const double allowed_m = start_tolerance_m * (1.0 + largest_component(carried_start_m_));
    if (p.kind == PrimitiveKind::directed || norm(residual(p, carried_start_m_)) > allowed_m) {
      return refuse(p.id, Refusal::drag_away_from_start);
    }
  }
  const bool is_further_facet = p.kind == PrimitiveKind::corner && size_ > 0 && primitives_[size_ - 1].kind == p.kind &&
                                primitives_[size_ - 1].id == p.id && primitives_[size_ - 1].strength_n == p.strength_n &&
                                primitives_[size_ - 1].stiffness_n_per_m == p.stiffness_n_per_m;
  if (is_further_facet) {
    const std::size_t count = whole_of(primitives(), size_ - 1).size();
    if (!takes_facet(size_ - count, count, p.direction)) return;
  } else {
    for (std::size_t i = size_; i-- > 0 && is_beside(primitives_[i].id, p.id);) {
      if (primitives_[i].id.slot == p.id.slot) return refuse(p.id, Refusal::slot_used_twice);
    }
  }
  if (size_ == capacity_) return refuse(p.id, Refusal::full);
  primitives_[size_] = p;
  captured_[size_] = captured;
  friction_[size_] = friction;
  rows_[size_ - facets_] = size_;
  ++size_;
}

bool PrimitiveSet::can_pull() const noexcept {
  for (std::size_t i = 0; i < size_; ++i) {
    if (primitives_[i].strength_n > 0.0 || primitives_[i].drag_ns_per_m > 0.0 || friction_[i].any()) return true;
  }
  return false;
}

bool PrimitiveSet::add_facet(std::size_t handle, const Vec3& position_m, const Vec3& normal) noexcept {
  const std::size_t i = row(handle);
  Primitive facet = primitives_[i];
  const auto refused = [&](Refusal reason) { return refuse(facet.id, reason), false; };
  if (facet.kind != PrimitiveKind::plane && facet.kind != PrimitiveKind::corner) return refused(Refusal::facet_without_plane);
  if (facet.drag_ns_per_m > 0.0) return refused(Refusal::facet_with_drag);
  if (!is_usable(position_m)) return refused(Refusal::position_not_finite);
  if (!is_unit(normal)) return refused(Refusal::direction_not_unit);
  facet.kind = PrimitiveKind::corner;
  facet.position_m = position_m;
  facet.direction = unit_to_rounding(normal);
  const std::size_t count = whole_of(primitives(), i).size();
  if (!takes_facet(i, count, facet.direction)) return false;
  if (size_ == capacity_) return refused(Refusal::full);

  primitives_[i].kind = PrimitiveKind::corner;
  const std::size_t at = i + count;
  std::copy_backward(&primitives_[at], &primitives_[size_], &primitives_[size_ + 1]);
  std::copy_backward(&captured_[at], &captured_[size_], &captured_[size_ + 1]);
  std::copy_backward(&friction_[at], &friction_[size_], &friction_[size_ + 1]);
  ++size_;
  primitives_[at] = facet;
  captured_[at] = captured_[i];
  friction_[at] = {};
  ++facets_;
  for (std::size_t& row : handles()) row += row >= at;
  return true;
}

// Whether the `count` facets from `first` on, at least one, can take a further facet.
bool PrimitiveSet::takes_facet(std::size_t first, std::size_t count, const Vec3& normal) noexcept {
  const auto refused = [&](Refusal reason) { return refuse(primitives_[first].id, reason), false; };
  if (count >= most_facets) return refused(Refusal::facets_full);
  return detail::can_take_facet({&primitives_[first], count}, normal) || refused(Refusal::corner_too_narrow);
}

void PrimitiveSet::remove_facet(std::size_t i) noexcept {
  for (std::size_t j = i + 1; j < size_; ++j) {
    primitives_[j - 1] = primitives_[j];
    captured_[j - 1] = captured_[j];
    friction_[j - 1] = friction_[j];
  }
  --size_;
  --facets_;
  for (std::size_t& row : handles()) row -= row > i;
}

void PrimitiveSet::set_directed(std::size_t i, const Vec3& force_n) noexcept {
  const double strength_n = norm(force_n);
  if (strength_n > 0.0) primitives_[i].direction = normalized(force_n);
  primitives_[i].strength_n = strength_n;
}

void PrimitiveSet::refuse(PrimitiveId id, Refusal reason) noexcept {
  ++dropped_;
  if (refused_size_ < max_refused) refused_[refused_size_++] = {id, reason};
}

}  // namespace palpa
