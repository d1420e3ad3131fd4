#include "palpa/core/law.h"

#include <algorithm>
#include <limits>

#include "palpa/core/newton_form.h"

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

PrimitiveState state_at(const Primitive& primitive, const Balance& balance) noexcept {
  if (primitive.kind == PrimitiveKind::directed) return PrimitiveState::off;
  const Vec3 d = primitive.position_m - balance.position_m;
  const double tolerance =
      balance.error_bound_m +
      8.0 * detail::epsilon * (largest_component(primitive.position_m) + largest_component(balance.position_m));
  if (primitive.kind == PrimitiveKind::plane) {
    const double behind = dot(primitive.direction, d);
    if (behind > tolerance) return PrimitiveState::slip;
    return behind < -tolerance ? PrimitiveState::off : PrimitiveState::stick;
  }
  return norm(residual(primitive, balance.position_m)) > tolerance ? PrimitiveState::slip : PrimitiveState::stick;
}

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
    if (p.kind == PrimitiveKind::plane) {
      const double t = std::clamp(dot(p.direction, forces_n[i]), 0.0, longest);
      const Plane plane{p.direction, dot(p.direction, B), t, p.strength_n, gamma, size_of(B)};
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
