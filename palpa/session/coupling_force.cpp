#include "palpa/session/coupling_force.h"

#include <utility>

#include "palpa/session/proxy_path.h"

namespace palpa {

namespace {
// Largest growth rate of a returned force, as for a command behind a guard (GuardOptions). Slower: a wall's force is missing
// for longer; faster: it returns as a kick.
constexpr double back_n_per_s = 1000.0;
}  // namespace

void CouplingForce::start(const Vec3& probe_m) noexcept {
  last_probe_m_ = probe_m;
  damper_.reset({});
}

void CouplingForce::reset() noexcept {
  damper_force_n_ = {};
  lag_.reset();
  lag_s_ = 0.0;
}

void CouplingForce::resume_in_changed_scene(const CouplingForce& other, const Damper& damper, bool keeps_it,
                                            const Vec3& proxy_m) noexcept {
  *this = other;
  if (keeps_it) return;
  damper_ = damper;
  damper_.reset(proxy_m - last_probe_m_ - lag_.withheld_m());
  damper_force_n_ = {};
}

CouplingForce::Update CouplingForce::update(const Walk& walk, const Vec3& probe_m, const CouplingOptions& coupling,
                                            double time_step_s) noexcept {
  const double k = coupling.stiffness_n_per_m;
  Update result;
  result.probe_step_m = probe_m - last_probe_m_;
  result.damper_j = dot(damper_force_n_, result.probe_step_m);
  Vec3 extension_m = walk.proxy_m - probe_m, released_m = walk.released_m;
  const double lagged_s = std::exchange(lag_s_, walk.is_complete ? 0.0 : lag_s_ + time_step_s);
  if (!walk.is_complete || lag_.any()) {
    // Withheld extension exerts no force, so that damper_j contains all of Eq. 1 except the spring's work.
    result.damper_j -= k * dot(lag_.withheld_m(), result.probe_step_m);
    const Vec3 left_m = walk.from_m - probe_m - lag_.withheld_m();
    const Vec3 all_m = extension_m;
    extension_m = lag_.applied_extension_m(all_m, walk.proxy_m - walk.followed_m, lag_s_, left_m);
    released_m = {};
    if (walk.is_complete) {
      released_m = lag_.give_back_m(time_step_s, back_n_per_s * time_step_s / k);  // no motion of the hand: nothing to damp
      result.given_back_n = k * norm(released_m);
      extension_m = all_m - lag_.withheld_m();
    }
  }
  result.relative_m_per_s = damper_.relative_velocity(extension_m, released_m, time_step_s, k);
  damper_force_n_ = coupling.damping_ns_per_m * result.relative_m_per_s;
  result.force_n = k * extension_m + damper_force_n_;  // Eq. 1
  result.has_just_faded = LagCompensator::has_faded(lag_s_) && !LagCompensator::has_faded(lagged_s);
  last_probe_m_ = probe_m;
  return result;
}

}  // namespace palpa
