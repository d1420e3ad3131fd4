#include "palpa/study/check_trial.h"

#include <algorithm>
#include <cmath>

#include "palpa/base/printed.h"
#include "palpa/device/front.h"
#include "palpa/study/feeler.h"
#include "palpa/study/movement.h"
#include "palpa/study/released_device.h"
#include "palpa/study/spectrum.h"
#include "palpa/study/unyielding.h"

namespace palpa {
namespace {

constexpr double rate_hz = 1000.0;
constexpr double lies_n = 0.3;   // beyond friction: less than the strength of any level meant to be felt
constexpr double leans_n = 1.5;  // beyond friction: weight of a resting finger
// [N·s/m] Least damping of that finger's flesh, a sixth of an arm's. More: the finger hides a stiff scene; less: a weight, no
// finger.
constexpr double finger_ns_per_m = 1.0;
// Fall of the device: a front is found up to a step too late, and a start on a level never meets it.
constexpr double falls_m = 1e-3 + detail::way_step_m;
constexpr double landed_s = 1.2;   // end of the fall of a released device
constexpr double watched_s = 1.1;  // of the interval at rest
constexpr double pressed_s = 4.0;  // in and out several times

Arm arm_of(Hold hold) { return hold == Hold::firm ? firm_arm : relaxed_arm; }

double push_beyond_friction_n(Act act) { return act == Act::lean ? leans_n : lies_n; }

std::unique_ptr<ReleasedDevice> release(const DevicePlant& plant, const CheckPlace& place, Act act) {
  const double most_n = push_beyond_friction_n(act) + plant.coulomb_friction_n;
  DevicePlant with_finger = plant;
  if (act == Act::lean) with_finger.damping_ns_per_m += finger_ns_per_m;
  return released_device(with_finger, place.front_m - falls_m * place.inwards, most_n * place.inwards);
}

// [rad] Tilt of a tool in a hand. More: feet enter far beyond the depth of the place; less: as if it were upright.
constexpr double tilts_rad = 0.1;

/// Target that tilts the handle to and fro, up to a time, and then holds it.
class Tilting final : public Target {
 public:
  Tilting(std::shared_ptr<const Target> target, double until_s) : target_(std::move(target)), until_s_(until_s) {}
  Point at(double time_s) const noexcept override {
    constexpr double rad_per_s = 3.0;
    Point point = target_->at(time_s);
    const double turned = rad_per_s * std::min(time_s, until_s_);
    point.turn = turn_by(tilts_rad * Vec3{std::sin(turned), 0.0, 0.5 * std::sin(2.0 * turned)});
    return point;
  }
  double duration_s() const noexcept override { return target_->duration_s(); }

 private:
  std::shared_ptr<const Target> target_;
  double until_s_;
};

/// Device of a trial with its lead, and the interval of rest or even motion.
struct Set {
  std::unique_ptr<SimulatedDevice> device;
  double from_s = 0.0, to_s = 0.0;
};
Set set_up(const DevicePlant& plant, const CheckPlace& place, const Trial& trial, bool turns) {
  const auto in_hand = [&](std::shared_ptr<const Target> target, double until_s) {
    if (turns) target = std::make_shared<Tilting>(std::move(target), until_s);
    return hand_device(std::move(target), trial.hold, plant);
  };
  const double depth_m = place.met.depth_m + place.deeper_n / arm_of(trial.hold).stiffness_n_per_m;
  switch (trial.act) {
    case Act::released:
    case Act::lean: return {release(plant, place, trial.act), landed_s, landed_s + watched_s};
    case Act::hold:
      return {in_hand(hold_at(place.met, 0.0, depth_m, {}, even_s + watched_s), 0.5 * even_s), even_s, even_s + watched_s};
    case Act::stroke: {
      const HandSlide slide = slide_over(place.met, 0.125, 0.0, depth_m);
      return {in_hand(slide.target, slide.to_s), slide.from_s, slide.to_s};
    }
    case Act::press: {
      const SimulatedMotion motion{.kind = SimulatedMotion::Kind::press, .depth_m = depth_m};
      return {in_hand(simulated_target(motion, place.met), pressed_s), 0.0, pressed_s};
    }
  }
  return {};
}

bool is_without_hand(Act act) { return act == Act::released || act == Act::lean; }

/// A device without a hand may slide off its place, out of contact: the rest is unrelated to the place. Cuts the run where the
/// device is beside or behind it, or, if thrown back, before it returns. False if it stays.
bool cut_where_it_leaves(const CheckPlace& place, FeltRun& run, Set& set) {
  constexpr double away_m = 0.02, just_landed_s = 0.4, short_s = 0.5;
  for (const FeltTick& tick : run.ticks) {
    const Vec3 gone_m = tick.probe_m - place.front_m;
    const double along_m = dot(gone_m, place.inwards);
    if (norm(gone_m - std::min(0.0, along_m) * place.inwards) <= away_m) continue;
    set.to_s = std::min(set.to_s, tick.t_s);
    if (set.to_s - set.from_s < short_s) set.from_s = just_landed_s;
    run.ticks.resize(static_cast<std::size_t>(&tick - run.ticks.data()));
    return true;
  }
  return false;
}

/// Whether the loop drove a device without a hand off its place: until it left, the rendered force gave it more energy, beyond
/// the injection of modes, than its push gave it on its fall. Its push alone slides it off at no such gain.
bool is_thrown_off(const Scene& scene, const DevicePlant& plant, const CheckPlace& place, const Trial& trial, double to_s) {
  const std::unique_ptr<ReleasedDevice> device = release(plant, place, trial.act);
  SummaryBuilder builder(scene);
  feel(scene, *device, to_s, &builder);
  double injected_j = 0.0;
  for (const ModeSummary& mode : builder.finish(1.0).modes) injected_j += mode.injected_j;
  return device->work_j() - injected_j > push_beyond_friction_n(trial.act) * falls_m;
}

/// Root mean square of the force in contact about its mean [N]: of a stay too short for a spectrum.
double unrest_n(const FeltRun& run) {
  Vec3 sum_n;
  double squares_n2 = 0.0, count = 0.0;
  for (const FeltTick& tick : run.ticks) {
    if (norm(tick.command_n) <= contact_force_n) continue;
    sum_n += tick.command_n;
    squares_n2 += norm_squared(tick.command_n);
    ++count;
  }
  return count > 0.0 ? std::sqrt(std::max(0.0, squares_n2 / count - norm_squared(sum_n) / (count * count))) : 0.0;
}

void find_jumps(const FeltRun& run, const EdgesOfData& edges, TrialFigures& figures) {
  for (const ExcessStep& step : excess_steps(run, &edges)) {
    if (step.excess_n > figures.jump_n) {
      figures.jump_n = step.excess_n;
      figures.jump_s = step.t_s;
      figures.jump_cause = step.cause;
    }
    if (has_event(step.cause)) continue;
    ++figures.unexplained_jumps;
    if (step.mode >= 0) figures.jump_mode = run.modes[static_cast<std::size_t>(step.mode)].name;
  }
}

void find_torque(const FeltRun& run, double limit_nm, TrialFigures& figures) {
  std::size_t over = 0;
  for (const FeltTick& tick : run.ticks) {
    const double torque_nm = norm(tick.torque_nm);
    figures.most_nm = std::max(figures.most_nm, torque_nm);
    over += torque_nm > limit_nm;
  }
  figures.over_torque = static_cast<double>(over) / static_cast<double>(std::max<std::size_t>(1, run.ticks.size()));
}

/// Root mean square [N] of the torque, as a force at the turning radius [m], between 5 and 500 Hz; 0 without a torque.
double turning_at_rest_n(const FeltRun& run, double from_s, double to_s, double radius_m) {
  std::vector<Vec3> forces_n;
  for (const FeltTick& tick : run.ticks) {
    if (tick.t_s >= from_s && tick.t_s < to_s) forces_n.push_back(tick.torque_nm / radius_m);
  }
  const bool any = std::ranges::any_of(forces_n, [](const Vec3& force_n) { return force_n != Vec3{}; });
  return any ? spectrum_of(forces_n, rate_hz).band_rms(5.0, tactile_high_hz) : 0.0;
}

/// A hand on a level stronger than the limit is at the limit by design; other force beyond the limit is lost.
void find_overfull(const Scene& scene, const FeltRun& run, TrialFigures& figures) {
  const std::vector<UnyieldingLevel> levels = unyielding_levels(scene, scene.coupling().max_force_n);
  figures.pushed_n.assign(run.modes.size(), 0.0);
  std::size_t ticks = 0;
  for (std::size_t t = 0; t < run.ticks.size(); ++t) {
    if (!run.ticks[t].limited) continue;
    const auto push_n = [&](const FeltMode& mode) { return norm(mode.force_n[t]); };
    const auto most = static_cast<std::size_t>(std::ranges::max_element(run.modes, {}, push_n) - run.modes.begin());
    if (std::ranges::find(levels, most, &UnyieldingLevel::mode) != levels.end()) continue;
    ++ticks;
    for (std::size_t m = 0; m < run.modes.size(); ++m)
      figures.pushed_n[m] = std::max(figures.pushed_n[m], push_n(run.modes[m]));
  }
  figures.overfull = run.ticks.empty() ? 0.0 : static_cast<double>(ticks) / static_cast<double>(run.ticks.size());
}

}  // namespace

const char* name_of(Act act) noexcept {
  switch (act) {
    case Act::released: return "released";
    case Act::lean: return "leaned on";
    case Act::hold: return "held";
    case Act::stroke: return "stroked";
    case Act::press: return "pressed";
  }
  return "";
}

std::string format_trial(const Trial& trial) {
  if (trial.friction < 1.0)
    return format_trial({trial.act, trial.hold}) + detail::text(", with %g of its friction", trial.friction);
  if (is_without_hand(trial.act)) return name_of(trial.act);
  return std::string(name_of(trial.act)) + (trial.hold == Hold::firm ? ", firm" : ", relaxed");
}

TrialFigures try_at(const Scene& scene, const DevicePlant& presumed, const CheckPlace& place, const Trial& trial) {
  DevicePlant plant = presumed;
  plant.coulomb_friction_n *= trial.friction;
  const Tool tool(scene.tool(), scene.coupling());
  Set set = set_up(plant, place, trial, !tool.is_point());
  SummaryBuilder builder(scene);
  FeltRun run = feel(scene, *set.device, set.to_s, &builder);
  const Summary summary = builder.finish(1.0);
  TrialFigures figures{.most_n = summary.force_max_n,
                       .duration_s = set.to_s,
                       .saturated = saturated_share(run),
                       .over_budget = static_cast<double>(summary.waiting_ticks) / static_cast<double>(summary.ticks),
                       .unborne_n = summary.unborne_lasting_n,
                       .sampling_gained_j = summary.sampling_gained_j};
  for (const ModeSummary& mode : summary.modes) {
    figures.injected_j.push_back(mode.injected_j);
    figures.dissipated_j.push_back(mode.dissipated_j);
  }
  if (is_without_hand(trial.act) && cut_where_it_leaves(place, run, set))
    figures.thrown_off = is_thrown_off(scene, plant, place, trial, set.to_s);
  find_jumps(run, EdgesOfData(scene), figures);
  find_overfull(scene, run, figures);
  find_torque(run, scene.coupling().max_torque_nm, figures);
  const bool rests = is_without_hand(trial.act) || trial.act == Act::hold;
  if (rests) {
    const Spectrum spectrum = spectrum_of(signals_of(run, set.from_s, set.to_s).command_n, rate_hz);
    figures.rest_n = figures.thrown_off ? unrest_n(run) : spectrum.band_rms(5.0, tactile_high_hz);
    if (plant.limits.max_torque_nm > 0.0 && !figures.thrown_off)
      figures.rest_n = std::hypot(figures.rest_n, turning_at_rest_n(run, set.from_s, set.to_s, tool.turning_radius_m()));
    figures.hum_m_per_s2 = figures.rest_n / plant.mass_kg;
  } else if (trial.act == Act::stroke) {
    const FeltSignals signals = quiet_signals_of(run, set.from_s, set.to_s);
    figures.rough_n = spectrum_of(signals.command_n, rate_hz).band_rms(rough_low_hz, tactile_high_hz);
  }
  return figures;
}

}  // namespace palpa
