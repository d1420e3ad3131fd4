#include "palpa/study/check.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/core/printed.h"
#include "palpa/study/feeler.h"
#include "palpa/study/let_go.h"

namespace palpa {
namespace {

using detail::text;

constexpr double period_s = 1e-3;
constexpr Trial all_trials[] = {{Act::let_go},
                                {Act::lean},
                                {Act::hold, Hold::relaxed},
                                {Act::hold, Hold::firm},
                                {Act::stroke, Hold::relaxed},
                                {Act::stroke, Hold::firm},
                                {Act::press, Hold::relaxed},
                                {Act::press, Hold::firm}};
constexpr Trial quick_trials[] = {{Act::let_go}, {Act::lean}, {Act::hold, Hold::relaxed}};

/// A trial that was made.
struct Made {
  std::size_t place = 0;
  Trial trial;
  TrialFigures figures;
};

/// The trial with the largest of a figure among those of these acts.
template <class Figure>
const Made* worst_of(const std::vector<Made>& all, std::initializer_list<Act> acts, const Figure& figure) {
  const Made* worst = nullptr;
  for (const Made& made : all) {
    if (std::find(acts.begin(), acts.end(), made.trial.act) == acts.end()) continue;
    if (!worst || figure(made.figures) > figure(worst->figures)) worst = &made;
  }
  return worst;
}

std::string where_of(const Made& made, const CheckPlace& place) {
  return words_of(made.trial) + " at the " + place.why +
         text(" place (%+.0f, %+.0f, %+.0f mm)", 1e3 * place.front_m.x, 1e3 * place.front_m.y, 1e3 * place.front_m.z);
}

class Judge {
 public:
  Judge(const Scene& scene, CheckReport& report, const std::vector<Made>& all) : scene_(scene), report_(report), all_(all) {}

  void rest(const char* key, std::initializer_list<Act> acts) {
    const Made* worst = worst_of(all_, acts, [](const TrialFigures& f) { return f.hum_m_per_s2; });
    if (!worst) return;
    const TrialFigures& figures = worst->figures;
    const Grade grade = detail::grade_of_rest(figures);
    add({.key = key,
         .grade = grade,
         .measured = figures.hum_m_per_s2,
         .threshold = grade == Grade::stop ? borne_acceleration_m_per_s2 : felt_acceleration_m_per_s2,
         .unit = "m/s^2",
         .words = grade == Grade::fine
                      ? std::string("it rests")
                      : std::string(grade == Grade::stop ? "it shakes" : "it hums") +
                            text(" by %.0f mN, which is %.2g m/s^2 of the device", 1e3 * figures.rest_n, figures.hum_m_per_s2)},
        worst);
  }

  void jump() {
    const Made* worst = worst_of(all_, moving, [](const TrialFigures& f) { return f.jump_n; });
    if (!worst) return;
    const TrialFigures& figures = worst->figures;
    add({.key = "jump",
         .grade = figures.jump_n > borne_jump_n ? Grade::stop : Grade::fine,
         .measured = figures.jump_n,
         .threshold = borne_jump_n,
         .unit = "N",
         .words = figures.jump_n > 0.0
                      ? text("the force steps by %.2g N in a tick (%s)", figures.jump_n, name_of(figures.jump_cause))
                      : text("no step of the force is felt as one")},
        worst);
  }
  void noise() {
    const Made* worst = worst_of(all_, moving, [](const TrialFigures& f) { return f.untold_jumps / f.duration_s; });
    if (!worst) return;
    const double per_s = worst->figures.untold_jumps / worst->figures.duration_s;
    const std::string whose = worst->figures.jump_mode.empty() ? "" : " by '" + worst->figures.jump_mode + "'";
    add({.key = "noise",
         .grade = worst->figures.untold_jumps > 0 ? Grade::warn : Grade::fine,
         .measured = per_s,
         .threshold = 0.0,
         .unit = "1/s",
         .words = worst->figures.untold_jumps > 0
                      ? text("%.1f steps a second over %.0f mN that no event tells%s: strength or direction varies faster than "
                             "the proxy steps",
                             per_s, 1e3 * felt_step_n, whose.c_str())
                      : "no strength and no direction varies faster than the proxy steps"},
        worst);
  }
  void ripple() {
    const Made* worst = worst_of(all_, {Act::stroke}, [](const TrialFigures& f) { return f.rough_n; });
    if (!worst) return;
    const double measured = worst->figures.rough_n / report_.plant.mass_kg;
    add({.key = "ripple",
         .grade = measured > felt_acceleration_m_per_s2 ? Grade::warn : Grade::fine,
         .measured = measured,
         .threshold = felt_acceleration_m_per_s2,
         .unit = "m/s^2",
         .words = text("a stroke has %.2g mN from 100 to 500 Hz", 1e3 * worst->figures.rough_n)},
        worst);
  }
  void saturation() {
    constexpr double seldom = 0.01;
    const Made* worst = worst_of(all_, {Act::hold, Act::stroke, Act::press}, [](const TrialFigures& f) { return f.saturated; });
    if (!worst) return;
    add({.key = "saturation",
         .grade = worst->figures.saturated > seldom ? Grade::warn : Grade::fine,
         .measured = worst->figures.saturated,
         .threshold = seldom,
         .unit = "1",
         .words = text("the device's force is at its limit, %g N, in %.0f %% of the ticks", scene_.coupling.max_force_n,
                       100.0 * worst->figures.saturated)},
        worst);
  }
  void budget() {
    constexpr double seldom = 1e-3;  // a proxy that lags for a tick pulls a tick later
    const Made* worst = worst_of(all_, everything, [](const TrialFigures& f) { return f.over_budget; });
    if (!worst) return;
    add({.key = "over_budget",
         .grade = worst->figures.over_budget > seldom ? Grade::warn : Grade::fine,
         .measured = worst->figures.over_budget,
         .threshold = seldom,
         .unit = "1",
         .words =
             text("the proxy lags behind in %.2g %% of the ticks, whose work is spent", 100.0 * worst->figures.over_budget)},
        worst);
  }
  void energy() {
    for (std::size_t m = 0; m < scene_.modes().size(); ++m) {
      const SceneMode& mode = scene_.modes()[m];
      if (!mode.enabled) continue;
      // A spring gives back what it took; only what is left of both was brought in.
      const auto net_j = [m](const TrialFigures& f) { return f.injected_j[m] - f.dissipated_j[m]; };
      const Made* worst = worst_of(all_, everything, net_j);
      const double injected_j = worst ? std::max(0.0, net_j(worst->figures)) : 0.0;
      // What wind and gradients push they push: their energy is the data's.
      const bool may = places_directed_forces(mode.mode.type());
      add({.key = "energy",
           .grade = !may && injected_j > borne_energy_j ? Grade::warn : Grade::fine,
           .measured = injected_j,
           .threshold = may ? INFINITY : borne_energy_j,
           .unit = "J",
           .words = "'" + mode.name + text("' brings in %.2g mJ at most", 1e3 * injected_j)},
          worst);
    }
  }

 private:
  static constexpr std::initializer_list<Act> moving = {Act::hold, Act::stroke, Act::press};
  static constexpr std::initializer_list<Act> everything = {Act::let_go, Act::lean, Act::hold, Act::stroke, Act::press};
  void add(Finding finding, const Made* made) {
    if (made) finding.where = where_of(*made, report_.places[made->place]);
    report_.findings.push_back(std::move(finding));
  }
  const Scene& scene_;
  CheckReport& report_;
  const std::vector<Made>& all_;
};

/// What can be said of k without the scene: a device alone on a wall, its friction taken away, because nobody has measured it.
Finding finding_of_margin(const CheckReport& report) {
  const double k = report.coupling.stiffness_n_per_m, most = report.stable.alone_n_per_m;
  return {.key = "margin",
          .grade = k > most ? Grade::warn : Grade::fine,
          .measured = k,
          .threshold = most,
          .unit = "N/m",
          .where = {},
          .words = k > most ? text("k = %g N/m rests by the device's friction alone; without it no more than %.0f do", k, most)
                            : text("k = %g N/m; the device alone bears %.0f", k, most)};
}

/// What the device does not bear is a change, too: from what the file says.
void own_up(const CouplingOptions& asked, const CouplingOptions& felt, CheckReport& report) {
  const auto own_up_to = [&](const char* key, double wanted, double taken) {
    if (wanted == taken) return;
    const auto known =
        std::find_if(report.changes.begin(), report.changes.end(), [&](const Change& c) { return c.key == key; });
    if (known != report.changes.end()) {
      known->from = wanted;
    } else {
      report.changes.push_back(
          {"coupling", key, wanted, taken, "the most that the device is made for, which is what was checked"});
    }
  };
  own_up_to("stiffness_n_per_m", asked.stiffness_n_per_m, felt.stiffness_n_per_m);
  own_up_to("damping_ns_per_m", asked.damping_ns_per_m, felt.damping_ns_per_m);
  own_up_to("max_force_n", asked.max_force_n, felt.max_force_n);
}

void conclude(CheckReport& report) {
  std::stable_sort(report.findings.begin(), report.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.grade > b.grade; });
  if (report.findings.empty()) {
    report.verdict = "nothing is felt within reach of a hand";
    return;
  }
  const Finding& gravest = report.findings.front();
  report.grade = gravest.grade;
  report.verdict = report.grade == Grade::fine ? "fine on " + report.plant.name + ": it rests, let go and held"
                                               : std::string(name_of(report.grade)) + " on " + report.plant.name + ": " +
                                                     gravest.words + (gravest.where.empty() ? "" : ", " + gravest.where);
}

}  // namespace

const char* name_of(Grade grade) noexcept {
  switch (grade) {
    case Grade::fine: return "fine";
    case Grade::warn: return "warn";
    case Grade::stop: return "stop";
  }
  return "";
}

Scene within(Scene scene, const DevicePlant& plant) {
  CouplingOptions& coupling = scene.coupling;
  coupling.max_force_n = std::min(coupling.max_force_n, plant.limits.max_force_n);
  coupling.stiffness_n_per_m = std::min(coupling.stiffness_n_per_m, plant.limits.max_stiffness_n_per_m);
  coupling.damping_ns_per_m = std::min(coupling.damping_ns_per_m, plant.limits.max_damping_ns_per_m);
  return scene;
}

DevicePlant checked_plant(DevicePlant plant) {
  if (!(plant.mass_kg > 0.0))
    throw LoadError("device: " + plant.name + " has no mass; a closed loop needs one, as in mass_kg=0.1");
  plant.delay_ticks = std::max(1, plant.delay_ticks);
  return plant;
}

std::optional<DevicePlant> plant_like(const std::string& description) {
  if (description.empty()) return std::nullopt;
  const std::string kind = description.substr(0, description.find(','));
  for (const std::string& known : {description, kind}) {
    try {
      if (DevicePlant plant = device_plant(known); plant.mass_kg > 0.0) return plant;
    } catch (const LoadError&) {
      // A real device has settings, and kinds, that no plant has.
    }
  }
  return std::nullopt;
}

Grade detail::grade_of_rest(const TrialFigures& figures) noexcept {
  if (figures.hum_m_per_s2 > borne_acceleration_m_per_s2) return Grade::stop;
  return figures.hum_m_per_s2 > felt_acceleration_m_per_s2 ? Grade::warn : Grade::fine;
}

namespace {

// Of the wall: softer than the first, the first tick's leap on it is longer than a tick's work; stiffer than the second, no
// device is.
constexpr double softest_n_per_m = 40.0, stiffest_n_per_m = 2e4;

/// Whether a device alone on a wall comes to rest though it is knocked by more than its friction holds.
bool rests_on_wall(const DevicePlant& plant, double stiffness_n_per_m, double damping_ns_per_m) {
  constexpr double knock = 3.0, frictionless_m = 3e-4;
  const LetGoOptions options{.plant = plant,
                             .damping_ns_per_m = damping_ns_per_m,
                             .start_depth_m = frictionless_m + knock * plant.coulomb_friction_n / stiffness_n_per_m};
  return comes_to_rest(options, stiffness_n_per_m);
}

}  // namespace

StableStiffness detail::stable_stiffness(const DevicePlant& plant, double damping_ns_per_m) {
  const auto largest = [&](const DevicePlant& on_wall) {
    return largest_stable_stiffness_n_per_m([&](double k) { return rests_on_wall(on_wall, k, damping_ns_per_m); },
                                            softest_n_per_m, stiffest_n_per_m);
  };
  DevicePlant frictionless = plant;
  frictionless.coulomb_friction_n = 0.0;
  return {.damping_ns_per_m = damping_ns_per_m,
          .alone_n_per_m = largest(frictionless),
          .friction_n_per_m = largest(plant),
          .bounds = stiffness_bounds(plant, damping_ns_per_m, period_s)};
}

double detail::largest_stable_damping_ns_per_m(const DevicePlant& plant, double stiffness_n_per_m) {
  constexpr double least = 0.05, most = 100.0;
  DevicePlant frictionless = plant;
  frictionless.coulomb_friction_n = 0.0;
  const auto rests = [&](double damping_ns_per_m) { return rests_on_wall(frictionless, stiffness_n_per_m, damping_ns_per_m); };
  for (double low = least; low < most; low *= 2.0) {
    if (rests(low)) return largest_stable_stiffness_n_per_m(rests, low, most);
  }
  return 0.0;
}

CheckReport detail::judged(const Scene& scene, const DevicePlant& plant, std::vector<CheckPlace> places, bool quick,
                           const std::function<void(double)>& progress) {
  CheckReport report{.plant = plant, .coupling = scene.coupling, .verdict = {}, .places = std::move(places)};
  std::vector<Made> all;
  for (std::size_t p = 0; p < report.places.size(); ++p) {
    if (quick) {
      for (const Trial& trial : quick_trials) all.push_back({p, trial, {}});
    } else {
      for (const Trial& trial : all_trials) all.push_back({p, trial, {}});
    }
  }
  in_parallel(
      feeling_threads(), static_cast<int>(all.size()),
      [&](std::size_t, int n) {
        Made& made = all[static_cast<std::size_t>(n)];
        made.figures = try_at(scene, plant, report.places[made.place], made.trial);
      },
      progress);
  for (const SceneMode& mode : scene.modes()) report.modes.push_back(mode.name);
  report.injected_j.resize(report.modes.size());
  report.dissipated_j.resize(report.modes.size());
  for (const Made& made : all) {
    report.most_force_n = std::max(report.most_force_n, made.figures.most_n);
    for (std::size_t m = 0; m < report.modes.size(); ++m) {
      report.injected_j[m] = std::max(report.injected_j[m], made.figures.injected_j[m]);
      report.dissipated_j[m] = std::max(report.dissipated_j[m], made.figures.dissipated_j[m]);
    }
  }
  report.stable = stable_stiffness(plant, scene.coupling.damping_ns_per_m);
  report.largest_damping_ns_per_m = largest_stable_damping_ns_per_m(plant, scene.coupling.stiffness_n_per_m);
  Judge judge(scene, report, all);
  if (!all.empty()) {
    judge.rest("let_go", {Act::let_go, Act::lean});
    judge.rest("held", {Act::hold});
    judge.jump();
    judge.noise();
    judge.ripple();
    judge.saturation();
    judge.budget();
    judge.energy();
    report.findings.push_back(finding_of_margin(report));
  }
  conclude(report);
  return report;
}

CheckReport check(const Scene& asked, const DevicePlant& asked_plant, const CheckOptions& options) {
  constexpr double spacing_m = 0.01;
  const DevicePlant plant = checked_plant(asked_plant);
  const Scene scene = within(asked, plant);
  const auto part = [&](double from, double to) -> std::function<void(double)> {
    if (!options.progress) return {};
    return [&options, from, to](double share) { options.progress(from + (to - from) * share); };
  };
  CheckReport report = detail::judged(scene, plant, check_places(scene, spacing_m, part(0.0, 0.2)), false, part(0.2, 0.5));
  if (options.advise) {
    detail::advise(scene, report, part(0.5, 0.9));
    own_up(asked.coupling, scene.coupling, report);
  }
  if (options.map) detail::draw_map(scene, report, part(0.9, 1.0));
  return report;
}

CheckReport check_quickly(const Scene& asked, const DevicePlant& asked_plant) {
  constexpr double spacing_m = 0.03;
  const DevicePlant plant = checked_plant(asked_plant);
  const Scene scene = within(asked, plant);
  std::vector<CheckPlace> places = check_places(scene, spacing_m);
  if (places.size() > 1) places.resize(1);
  return detail::judged(scene, plant, std::move(places), true, {});
}

}  // namespace palpa
