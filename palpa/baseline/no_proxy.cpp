#include "palpa/baseline/no_proxy.h"

namespace palpa::baseline {

void NoProxy::reset() noexcept {
  EarlierLaw::reset();
  last_.reset();
}

EarlierLaw::Moved NoProxy::move(const Posed& posed, std::span<Vec3> forces_n) noexcept {
  // Within a tick this balance may be solved again, with the friction that follows from the first result. The probe has not
  // moved in between: its velocity stays that of the first call.
  const Asked asked{posed.start_m, posed.probe_m};
  if (last_ != asked) {
    probe_before_m_ = last_ ? last_->probe_m : posed.probe_m;
    last_ = asked;
  }
  const double T = posed.time_step_s;
  const Vec3 velocity_m_per_s = T > 0.0 ? (posed.probe_m - probe_before_m_) / T : Vec3{};

  Moved moved{posed.target_m};
  for (std::size_t i = 0; i < posed.primitives.size(); ++i) {
    const Primitive& p = posed.primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    const Vec3 v = part_in_span(p, velocity_m_per_s);
    if (p.kind == PrimitiveKind::plane) {
      const double depth_m = dot(p.direction, p.position_m - posed.probe_m);
      if (!(depth_m > 0.0)) continue;
      const double inwards_m_per_s = std::max(0.0, -dot(p.direction, v));
      forces_n[i] =
          (std::min(posed.stiffness_n_per_m * depth_m, p.strength_n) + p.drag_ns_per_m * inwards_m_per_s) * p.direction;
    } else {
      forces_n[i] = -p.strength_n * normalized(v) - p.drag_ns_per_m * v;
    }
    moved.proxy_m += forces_n[i] / posed.stiffness_n_per_m;
  }
  return moved;
}

}  // namespace palpa::baseline
