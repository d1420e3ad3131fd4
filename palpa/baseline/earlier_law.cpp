#include "palpa/baseline/earlier_law.h"

#include <cassert>
#include <limits>

namespace palpa::baseline {

namespace {

// Stiffest accepted k, as for the exact law: larger values could overflow, and are `bad_input`.
constexpr double stiffest_n_per_m = 1e12;

bool usable(const Vec3& position_m) noexcept {
  return is_finite(position_m) && largest_component(position_m) <= largest_position_m;
}

double within_reach(double coordinate_m) noexcept { return std::clamp(coordinate_m, -largest_position_m, largest_position_m); }

}  // namespace

EarlierLaw::EarlierLaw(std::size_t capacity) : capacity_(capacity), forces_(std::make_unique<Vec3[]>(capacity)) {}

Balance EarlierLaw::solve(const PrimitiveSet& set, const Vec3& start_m, const Vec3& probe_m, double k, double T) noexcept {
  assert(set.size() <= capacity_);
  const std::span<const Primitive> primitives = set.primitives().first(std::min(set.size(), capacity_));
  size_ = primitives.size();
  const std::span<Vec3> forces{forces_.get(), size_};

  Vec3 directed_n;
  bool drags = false;
  for (std::size_t i = 0; i < size_; ++i) {
    const Primitive& p = primitives[i];
    forces[i] = p.kind == PrimitiveKind::directed ? p.strength_n * p.direction : Vec3{};
    directed_n += forces[i];
    drags = drags || p.drag_ns_per_m > 0.0;
  }
  const bool time_usable = !drags || (std::isfinite(T) && T > 0.0);
  if (!(k > 0.0) || !(k <= stiffest_n_per_m) || !time_usable || !usable(start_m) || !usable(probe_m)) {
    std::fill(forces.begin(), forces.end(), Vec3{});
    return {usable(start_m) ? start_m : Vec3{}, std::numeric_limits<double>::max(), BalanceStatus::bad_input, 0, 0};
  }
  if (primitives.empty()) return {probe_m, 0.0, BalanceStatus::baseline, 0, 0};

  if (drags) T = std::max(T, shortest_time_s);
  const Moved moved = move({primitives, start_m, probe_m, k, T, probe_m + directed_n / k}, forces);
  Vec3 x_m = start_m;
  if (is_finite(moved.proxy_m)) {
    x_m = {within_reach(moved.proxy_m.x), within_reach(moved.proxy_m.y), within_reach(moved.proxy_m.z)};
  }
  for (Vec3& force : forces) {
    if (!is_finite(force)) force = {};
  }
  return {x_m, error_bound_m(primitives, forces, x_m, probe_m, k, T), BalanceStatus::baseline, 1, moved.iterations};
}

Vec3 part_in_span(const Primitive& primitive, const Vec3& v) noexcept {
  const Vec3& q = primitive.direction;
  switch (primitive.kind) {
    case PrimitiveKind::point: return v;
    case PrimitiveKind::line: return v - dot(q, v) * q;
    case PrimitiveKind::plane:
    case PrimitiveKind::corner: return dot(q, v) * q;
    case PrimitiveKind::directed: return {};
  }
  return {};
}

Vec3 answer_n(const Primitive& primitive, const Vec3& pull_n, double k, double T) noexcept {
  const Vec3 pull = part_in_span(primitive, pull_n);
  const bool is_plane = primitive.kind == PrimitiveKind::plane || primitive.kind == PrimitiveKind::corner;
  if (is_plane && dot(primitive.direction, pull) <= 0.0) return {};
  const double demanded = norm(pull);
  if (demanded <= primitive.strength_n) return pull;
  const double C = primitive.drag_ns_per_m > 0.0 ? primitive.drag_ns_per_m / T : 0.0;
  const double given = primitive.strength_n + C * ((demanded - primitive.strength_n) / (k + C));
  return (given / demanded) * pull;
}

}  // namespace palpa::baseline
