#include "palpa/session/coupling_force.h"

#include <utility>

namespace palpa {

namespace {
// A withheld force grows by no more than this, as a command does behind a guard (GuardOptions). Slower: a wall's force is
// missing for longer; faster: it comes back as a kick.
constexpr double back_n_per_s = 1000.0;
}  // namespace

void CouplingForce::start(const Vec3& probe_m) noexcept {
  last_probe_m_ = probe_m;
  damper_.reset({});
  lost_j_ = stored_j_;
}

void CouplingForce::let_go() noexcept {
  damper_force_n_ = {};
  slack_.reset();
  waits_s_ = 0.0;
}

double CouplingForce::lose_stored_j() noexcept { return std::exchange(stored_j_, 0.0); }

void CouplingForce::resume_in_changed_scene(const CouplingForce& other, const Damper& damper, bool keeps_it,
                                            const Vec3& proxy_m) noexcept {
  *this = other;
  if (keeps_it) return;
  damper_ = damper;
  damper_.reset(proxy_m - last_probe_m_ - slack_.unfelt_m());
  damper_force_n_ = {};
}

CouplingForce::Answer CouplingForce::answer(const Walked& walked, const Vec3& probe_m, const CouplingOptions& coupling,
                                            double time_step_s) noexcept {
  const double k = coupling.stiffness_n_per_m;
  const Vec3 step_m = this->step_m(probe_m);
  Vec3 stretch_m = walked.proxy_m - probe_m, released_m = walked.released_m;
  double given_back_n = 0.0;
  damper_j_ = dot(damper_force_n_, step_m);
  const double waited_s = std::exchange(waits_s_, walked.waits ? waits_s_ + time_step_s : 0.0);
  if (walked.waits || slack_.any()) {                 // what waits does not pull
    damper_j_ -= k * dot(slack_.unfelt_m(), step_m);  // so that it is all that Eq. 1 has beside the spring's
    const Vec3 left_m = walked.from_m - probe_m - slack_.unfelt_m();
    const Vec3 all_m = stretch_m;
    stretch_m = slack_.felt_m(all_m, walked.proxy_m - walked.followed_m, waits_s_, left_m);
    released_m = {};
    if (!walked.waits) {
      released_m = slack_.give_back_m(time_step_s, back_n_per_s * time_step_s / k);  // no motion of the hand: nothing to damp
      given_back_n = k * norm(released_m);
      stretch_m = all_m - slack_.unfelt_m();
    }
  }
  const Vec3 relative_m_per_s = damper_.relative_velocity(stretch_m, released_m, time_step_s, k);
  const Vec3 damping_n = coupling.damping_ns_per_m * relative_m_per_s;
  damper_force_n_ = damping_n;
  last_probe_m_ = probe_m;
  const bool has_just_faded = LagCompensator::has_faded(waits_s_) && !LagCompensator::has_faded(waited_s);
  return {k * stretch_m + damping_n, relative_m_per_s, has_just_faded, given_back_n};  // Eq. 1
}

void CouplingForce::book(Energy& energy) noexcept {
  energy.let_go_j += std::exchange(lost_j_, 0.0);
  energy.damper_j = damper_j_;
  stored_j_ = energy.stored_j + energy.elastic_j;
}

}  // namespace palpa
