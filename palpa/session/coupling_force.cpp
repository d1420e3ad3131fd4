#include "palpa/session/coupling_force.h"

#include <utility>

#include "palpa/session/proxy_path.h"

namespace palpa {

namespace {
// Largest growth rate of a returned force, as for a command behind a guard (GuardOptions). Slower: a wall's force is missing
// for longer; faster: it returns as a kick.
constexpr double back_n_per_s = 1000.0;
}  // namespace

void CouplingForce::start(const Pose& probe) noexcept {
  last_probe_ = probe;
  damper_.reset({});
}

void CouplingForce::reset() noexcept {
  damper_force_n_ = damper_torque_nm_ = {};
  lag_.reset();
  lag_s_ = 0.0;
}

void CouplingForce::resume_in_changed_scene(const CouplingForce& other, const Damper& damper, bool keeps_it,
                                            const Motion& extension_m) noexcept {
  *this = other;
  if (keeps_it) return;
  damper_ = damper;
  damper_.reset(extension_m - lag_.withheld_m());
  damper_force_n_ = damper_torque_nm_ = {};
}

CouplingForce::Update CouplingForce::update(const Walk& walk, const Pose& probe, const CouplingOptions& coupling,
                                            const Tool& tool, double time_step_s) noexcept {
  const double k = coupling.stiffness_n_per_m, radius_m = tool.turning_radius_m();
  const Motion probe_step_m = tool.motion(last_probe_, probe);
  double damper_j = dot(damper_force_n_, probe_step_m.way_m), given_back_n = 0.0;
  if (!tool.is_point()) damper_j += dot(damper_torque_nm_ / radius_m, probe_step_m.arc_m);
  Motion extension_m = tool.motion(probe, walk.proxy), released_m = walk.released_m;
  const double lagged_s = std::exchange(lag_s_, walk.is_complete ? 0.0 : lag_s_ + time_step_s);
  if (!walk.is_complete || lag_.any()) {
    // Withheld extension exerts no force, so that damper_j contains all of Eq. 1 except the spring's work.
    damper_j -= k * dot(lag_.withheld_m(), probe_step_m);
    const Motion left_m = tool.motion(probe, walk.from) - lag_.withheld_m();
    const Motion all_m = extension_m;
    extension_m = lag_.applied_extension_m(all_m, tool.motion(walk.followed, walk.proxy), lag_s_, left_m);
    released_m = {};
    if (walk.is_complete) {
      released_m = lag_.give_back_m(time_step_s, back_n_per_s * time_step_s / k);  // no motion of the hand: nothing to damp
      given_back_n = k * length(released_m);
      extension_m = all_m - lag_.withheld_m();
    }
  }
  const Motion relative = damper_.relative_velocity(extension_m, released_m, time_step_s, k);
  damper_force_n_ = coupling.damping_ns_per_m * relative.way_m;
  Vec3 torque_nm;
  if (!tool.is_point()) {
    const double damping_nms_per_rad =
        coupling.turn_damping_nms_per_rad.value_or(coupling.damping_ns_per_m * radius_m * radius_m);
    damper_torque_nm_ = damping_nms_per_rad / radius_m * relative.arc_m;
    torque_nm = k * radius_m * extension_m.arc_m + damper_torque_nm_;
  }
  last_probe_ = probe;
  return {.force_n = k * extension_m.way_m + damper_force_n_,  // Eq. 1
          .torque_nm = torque_nm,
          .probe_step_m = probe_step_m,
          .relative_m_per_s = relative.way_m,
          .damper_j = damper_j,
          .given_back_n = given_back_n,
          .has_just_faded = LagCompensator::has_faded(lag_s_) && !LagCompensator::has_faded(lagged_s)};
}

}  // namespace palpa
