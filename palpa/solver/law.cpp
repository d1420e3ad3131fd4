#include "palpa/solver/law.h"

#include <algorithm>
#include <limits>

#include "palpa/solver/double2.h"
#include "palpa/solver/newton_form.h"

namespace palpa {

const char* name_of(BalanceStatus status) noexcept {
  switch (status) {
    case BalanceStatus::exact: return "exact";
    case BalanceStatus::capped: return "capped";
    case BalanceStatus::bad_input: return "bad_input";
    case BalanceStatus::baseline: return "baseline";
  }
  return "?";
}

namespace {

// Distance that counts as contact [m].
double nearness_m(const Primitive& primitive, const Balance& balance) noexcept {
  return balance.error_bound_m +
         8.0 * detail::epsilon * (largest_component(primitive.position_m) + largest_component(balance.position_m));
}

// Largest deflection while it holds [m].
double given_way_m(const Primitive& primitive) noexcept { return primitive.strength_n / primitive.stiffness_n_per_m; }

}  // namespace

double fall_j(const Primitive& p, const Vec3& from_m, const Vec3& to_m, double time_step_s) noexcept {
  if (p.kind == PrimitiveKind::directed) return p.strength_n * dot(p.direction, to_m - from_m);
  time_step_s = std::max(time_step_s, shortest_time_s);
  const auto term_j = [&](const Vec3& x_m) {
    const double off_m = norm(residual(p, x_m));
    if (p.is_elastic()) {
      const double given_n = std::min(p.stiffness_n_per_m * off_m, p.strength_n);
      return given_n * (off_m - 0.5 * given_n / p.stiffness_n_per_m);
    }
    return p.strength_n * off_m + (p.drag_ns_per_m > 0.0 ? 0.5 * p.drag_ns_per_m / time_step_s * off_m * off_m : 0.0);
  };
  return term_j(from_m) - term_j(to_m);
}

PrimitiveState state_at(const Primitive& primitive, const Balance& balance) noexcept {
  if (primitive.kind == PrimitiveKind::directed) return PrimitiveState::off;
  const Vec3 d = primitive.position_m - balance.position_m;
  const double tolerance = nearness_m(primitive, balance);
  if (primitive.kind == PrimitiveKind::plane || primitive.kind == PrimitiveKind::corner) {
    const double behind = dot(primitive.direction, d);
    if (behind > tolerance + given_way_m(primitive)) return PrimitiveState::slip;
    return behind < -tolerance ? PrimitiveState::off : PrimitiveState::stick;
  }
  return norm(residual(primitive, balance.position_m)) > tolerance ? PrimitiveState::slip : PrimitiveState::stick;
}

PrimitiveState state_at(std::span<const Primitive> primitives, std::size_t i, const Balance& balance) noexcept {
  const std::span<const Primitive> facets = whole_of(primitives, i);
  if (facets.size() == 1 || facets.size() > most_facets) return state_at(primitives[i], balance);
  double tolerance = 0.0;
  for (const Primitive& facet : facets) tolerance = std::max(tolerance, nearness_m(facet, balance));
  if (norm(detail::way_out(facets, balance.position_m)) > tolerance + given_way_m(facets[0])) return PrimitiveState::slip;
  for (const Primitive& facet : facets) {
    if (state_at(facet, balance) != PrimitiveState::off) return PrimitiveState::stick;
  }
  return PrimitiveState::off;
}

Vec3 pressed_direction(std::span<const Primitive> facets, std::span<const Vec3> forces_n) noexcept {
  Vec3 force_n, normal;
  int pressing = 0;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    if (forces_n[i] == Vec3{}) continue;
    force_n += forces_n[i];
    normal = facets[i].direction;
    ++pressing;
  }
  if (pressing <= 1) return normal;
  return norm(force_n) > 0.0 ? normalized(force_n) : Vec3{};
}

namespace {

// Corner of these facets about x, with the forces of a face of it.
struct PosedCorner {
  PosedCorner(std::span<const Primitive> facets, std::span<const Vec3> forces_n, const Vec3& x_m, double k) noexcept {
    double t[most_facets];
    for (std::size_t i = 0; i < facets.size(); ++i) {
      normals[i] = facets[i].direction;
      b[i] = k * detail::slide(normals[i], facets[i].position_m, x_m).along;
      t[i] = std::max(0.0, dot(normals[i], forces_n[i]));
    }
    corner.normals = {normals, facets.size()};
    corner.b = b;
    corner.s = facets[0].strength_n;
    corner.compliance = detail::compliance_of(facets[0], k);
    for (std::size_t i = 0; i < facets.size(); ++i) {
      if (t[i] > 0.0 && corner.face.take(static_cast<int>(i), normals[i])) corner.t[corner.face.size - 1] = t[i];
    }
    corner.gather(false);
  }
  PosedCorner(const PosedCorner&) = delete;

  Vec3 normals[most_facets];
  double b[most_facets];
  detail::Corner corner;
};

}  // namespace

double error_bound_m(std::span<const Primitive> primitives, std::span<const Vec3> forces_n, const Vec3& x_m,
                     const Vec3& probe_m, double stiffness_n_per_m, double time_step_s) noexcept {
  using namespace detail;
  // About x itself: Z = 0.
  const double k = stiffness_n_per_m;
  const bool drags =
      std::any_of(primitives.begin(), primitives.end(), [](const Primitive& p) { return p.drag_ns_per_m > 0.0; });
  if (!(k > 0.0) || (drags && !(time_step_s > 0.0))) return std::numeric_limits<double>::max();
  Vec3 C = k * (probe_m - x_m);
  double size = size_of(C);
  double terms = 1.0;
  for (const Primitive& p : primitives) {
    if (p.kind != PrimitiveKind::directed) continue;
    C += p.strength_n * p.direction;
    size += 2.0 * p.strength_n;
    terms += 1.0;
  }
  Proof proof({}, C, size, terms);
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    const Vec3 B = k * (p.position_m - x_m);
    const double gamma = gamma_of(p, k, time_step_s);
    const double longest = gamma > 0.0 ? std::numeric_limits<double>::infinity() : p.strength_n;
    const std::span<const Primitive> facets = whole_of(primitives, i);
    if (facets.size() > most_facets) return std::numeric_limits<double>::max();
    if (facets.size() > 1) {
      const PosedCorner posed(facets, forces_n.subspan(i, facets.size()), x_m, k);
      proof.add(gap(posed.corner, {}), posed.corner.u);
      i += facets.size() - 1;
      continue;
    }
    if (p.kind == PrimitiveKind::plane || p.kind == PrimitiveKind::corner) {
      const double t = std::clamp(dot(p.direction, forces_n[i]), 0.0, longest);
      Plane plane{p.direction, dot(p.direction, B), t, p.strength_n, gamma, size_of(B)};
      plane.compliance = compliance_of(p, k);
      proof.add(gap(plane, {}, 0.0), t * p.direction);
    } else {
      const Vec3 q = p.kind == PrimitiveKind::line ? p.direction : Vec3{};
      Span span{q, B, forces_n[i], p.strength_n, gamma, size_of(B)};
      span.B = span.across(B);
      span.u = shortened(span.across(span.u), longest);
      proof.add(gap(span, {}), span.u);
    }
  }
  const double bound = proof.bound() / k * (1.0 + epsilon);
  return std::isfinite(bound) ? bound : std::numeric_limits<double>::max();
}

}  // namespace palpa
