#include "palpa/loop/clutch_mapping.h"

#include <algorithm>
#include <utility>

#include "palpa/device/turn_of.h"

namespace palpa {

namespace {
// Border, as a share [1] of the workspace's radius. Larger: less range for the speed; smaller: less room to feel.
constexpr double border_share = 0.85;
// Speed of the probe at the radius itself [m/s]. Faster: hard to stop; slower: tedious.
constexpr double border_m_per_s = 0.08;
// Tolerance of a rotation. More: a shear passes; less: rounding does not.
constexpr double rotation_error = 1e-6;
}  // namespace

void ClutchMapping::turn(const Mat3& turn) noexcept {
  if (!is_rotation(turn, rotation_error) || turn == turn_) return;
  turn_ = turn;
  quaternion_ = turn_of(turn);
  turned_ = true;
}

ClutchMapping::Held ClutchMapping::hold(const DeviceState& state, double time_step_s) noexcept {
  Held held{.probe = {.position_m = turn_ * state.position_m + offset_m_, .valid = state.valid, .buttons = state.buttons}};
  // A quaternion that is no turn stays as wrong as it is: the session refuses it.
  if (state.turn) held.probe.turn = quaternion_ * *state.turn;
  if (state.velocity_m_per_s) held.probe.velocity_m_per_s = turn_ * *state.velocity_m_per_s;
  if (!state.valid || !is_finite(state.position_m)) return held;
  // The probe stays in place while the view turns or the clutch is held: the offset absorbs the motion.
  held.moves = std::exchange(turned_, false) || (state.buttons & options_.clutch_buttons) != 0;
  if (held.moves && has_probe_) {
    offset_m_ = probe_m_ - turn_ * state.position_m;
    held.probe.velocity_m_per_s.reset();
  } else if (options_.goes_on_at_border) {
    const double far_m = norm(state.position_m);
    const double begins_m = border_share * options_.workspace_radius_m;
    const double share = std::clamp((far_m - begins_m) / (options_.workspace_radius_m - begins_m), 0.0, 1.0);
    if (share > 0.0) offset_m_ += (time_step_s * share * border_m_per_s / far_m) * (turn_ * state.position_m);
  }
  held.probe.position_m = probe_m_ = turn_ * state.position_m + offset_m_;
  has_probe_ = true;
  return held;
}

Wrench ClutchMapping::at_device(const Wrench& wrench) const noexcept {
  return {transposed_times(turn_, wrench.force_n), transposed_times(turn_, wrench.torque_nm)};
}

}  // namespace palpa
