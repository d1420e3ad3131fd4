#include "palpa/study/check.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/loop/loop.h"
#include "palpa/study/check_judge.h"
#include "palpa/study/feeler.h"
#include "palpa/study/released_device.h"
#include "palpa/trace/windows.h"

namespace palpa {
namespace {

constexpr double period_s = 1e-3;
constexpr Trial all_trials[] = {{Act::released},
                                {Act::lean},
                                {Act::hold, Hold::relaxed},
                                {Act::hold, Hold::firm},
                                {Act::stroke, Hold::relaxed},
                                {Act::stroke, Hold::firm},
                                {Act::press, Hold::relaxed},
                                {Act::press, Hold::firm},
                                {Act::released, Hold::relaxed, sure_friction},
                                {Act::lean, Hold::relaxed, sure_friction}};
constexpr Trial quick_trials[] = {{Act::released},
                                  {Act::lean},
                                  {Act::hold, Hold::relaxed},
                                  {Act::released, Hold::relaxed, sure_friction},
                                  {Act::lean, Hold::relaxed, sure_friction}};

/// Reports the device's limits as changes from the file's values.
void own_up(const CouplingOptions& asked, const CouplingOptions& felt, CheckReport& report) {
  const auto own_up_to = [&](const char* key, double wanted, double taken) {
    if (wanted == taken) return;
    const auto known =
        std::find_if(report.changes.begin(), report.changes.end(), [&](const Change& c) { return c.key == key; });
    if (known != report.changes.end()) {
      known->from = wanted;
    } else {
      report.changes.push_back(
          {"coupling", key, wanted, taken, "the maximum that the device is made for, and the value that was checked"});
    }
  };
  own_up_to("stiffness_n_per_m", asked.stiffness_n_per_m, felt.stiffness_n_per_m);
  own_up_to("damping_ns_per_m", asked.damping_ns_per_m, felt.damping_ns_per_m);
  own_up_to("max_force_n", asked.max_force_n, felt.max_force_n);
}

/// Likewise the device's limit of the stiffness of turning, which is no key of the coupling.
void own_up_to_turning(const Scene& asked, const Scene& felt, CheckReport& report) {
  const double wanted_m = Tool(asked.tool(), asked.coupling()).turning_radius_m();
  if (report.turning_radius_m == 0.0 || wanted_m == report.turning_radius_m) return;
  const auto kappa = [](const Scene& scene, double radius_m) {
    return scene.coupling().stiffness_n_per_m * radius_m * radius_m;
  };
  report.advice.push_back(
      detail::text("Turning has %.3g N·m/rad on this device instead of %.3g: tool.turning_radius_m = %.3g, "
                   "the value that was checked.",
                   kappa(felt, report.turning_radius_m), kappa(asked, wanted_m), report.turning_radius_m));
}

}  // namespace

Scene within(Scene scene, const DevicePlant& plant) {
  scene.edit<CouplingOptions>([&](CouplingOptions& coupling) {
    coupling.max_force_n = std::min(coupling.max_force_n, plant.limits.max_force_n);
    if (plant.limits.max_torque_nm > 0.0) coupling.max_torque_nm = std::min(coupling.max_torque_nm, plant.limits.max_torque_nm);
  });
  return clamped_to(std::move(scene), plant.limits);
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

namespace {

// Stiffness of the wall: if softer than the first, the first tick's step onto it exceeds a tick's work; no device is stiffer
// than the second.
constexpr double softest_n_per_m = 40.0, stiffest_n_per_m = 2e4;

/// Whether a device alone on a wall comes to rest after a knock beyond its friction.
bool rests_on_wall(const DevicePlant& plant, double stiffness_n_per_m, double damping_ns_per_m) {
  constexpr double knock = 3.0, frictionless_m = 3e-4;
  const ReleasedDeviceOptions options{.plant = plant,
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
  CheckReport report{.plant = plant, .coupling = scene.coupling(), .verdict = {}, .places = std::move(places)};
  std::vector<TrialMade> all;
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
        TrialMade& made = all[static_cast<std::size_t>(n)];
        made.figures = try_at(scene, plant, report.places[made.place], made.trial);
      },
      progress);
  if (const Tool tool(scene.tool(), scene.coupling()); !tool.is_point()) {
    report.turning_radius_m = tool.turning_radius_m();
    report.reach_m = tool.reach_m();
  }
  for (const SceneMode& mode : scene.modes()) report.modes.push_back(mode.name);
  report.injected_j.resize(report.modes.size());
  report.dissipated_j.resize(report.modes.size());
  for (const TrialMade& made : all) {
    if (made.trial.friction < 1.0) continue;
    report.most_force_n = std::max(report.most_force_n, made.figures.most_n);
    report.most_torque_nm = std::max(report.most_torque_nm, made.figures.most_nm);
    for (std::size_t m = 0; m < report.modes.size(); ++m) {
      report.injected_j[m] = std::max(report.injected_j[m], made.figures.injected_j[m]);
      report.dissipated_j[m] = std::max(report.dissipated_j[m], made.figures.dissipated_j[m]);
    }
  }
  report.stable = stable_stiffness(plant, scene.coupling().damping_ns_per_m);
  report.largest_damping_ns_per_m = largest_stable_damping_ns_per_m(plant, scene.coupling().stiffness_n_per_m);
  judge(scene, all, report);
  return report;
}

namespace {

/// Octaves to expect of the volumes that modes feel through windows. One loader makes those of all fields, and of the frames
/// of a series that are needed together.
std::vector<CheckedOctaves> expected_of(const Scene& scene, const ReadOptions& read) {
  constexpr int slots = 16;  // [1] More: more memory; fewer: slow disks are used less
  std::vector<CheckedOctaves> octaves;
  const std::vector<TracedField> fields = traced_fields(scene);
  if (fields.empty()) return octaves;
  const Session session(scene);
  const Stock& stock = session.stock();
  int loaded = 0;
  stock.for_each_needed_live(scene.time().at(0.0), [&](std::size_t, double) { ++loaded; });
  for (const TracedField& field : fields) {
    const auto& request = scene.find_volume(field.volume)->volume.request;
    bool is_felt = false;
    for (std::size_t n = 0; n < stock.size(); ++n) is_felt = is_felt || &stock.octaves(n) == field.octaves;
    if (!is_felt || !request || (!octaves.empty() && octaves.back().volume == field.volume)) continue;
    StoreReader reader(request->files.front(), read, slots);
    // A derived field, a store of its own, may have more octaves.
    const int count = std::min(field.octaves->count(), static_cast<int>(reader.contents().octaves.size()));
    octaves.push_back(
        {field.volume, expected_octaves(reader.contents(), count, field.posed->spacing_m() / scene.hand_to_world().scale,
                                        measured_chunk_s(reader), loaded)});
  }
  return octaves;
}

}  // namespace

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
    own_up(asked.coupling(), scene.coupling(), report);
    own_up_to_turning(asked, scene, report);
  }
  report.octaves = expected_of(scene, options.read);
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
