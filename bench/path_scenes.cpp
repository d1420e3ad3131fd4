// Whole scenes: halved steps, still hands, energy.
#include "bench/path_scenes.h"

#include <palpa/file/read_volume.h>
#include <palpa/scene/load_scene.h>

#include <algorithm>
#include <cstdio>
#include <map>

namespace palpa::bench {

using namespace palpa::test;

std::vector<std::string> scene_files(const PathOptions& options) {
  if (!options.scenes.empty()) return options.scenes;
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(options.scenes_folder)) {
    const bool phantom = entry.path().stem().string().ends_with("_phantom");
    if (entry.path().extension() == ".toml" && (phantom || !options.data_folder.empty())) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

std::string short_name(const std::string& file) { return std::filesystem::path(file).stem().string(); }

namespace {
SceneOptions scene_options(const PathOptions& options) {
  SceneOptions found;
  if (!options.data_folder.empty()) found.data_folders = {options.data_folder};
  return found;
}
}  // namespace

Scene load_still(const std::string& file, const PathOptions& options,
                 const std::vector<std::pair<std::string, std::string>>& sets) {
  SceneOptions with_sets = scene_options(options);
  with_sets.sets = sets;
  return load_scene(file, volume_reader(), standard_modes(), with_sets).scene;
}

std::vector<Probe> recorded_probes(const std::string& file, const PathOptions& options, double seconds) {
  RunOptions run;
  run.scene = file;
  run.scene_options = scene_options(options);
  run.hand = options.data_folder.empty()
                 ? "sim:stroke"
                 : (options.data_folder / "trajectories/inverse3_woodcarving_20231121_102837.csv").string();
  run.hold = Hold::firm;
  run.recording.center = true;  // independent of the scene: figures are compared over versions
  if (seconds > 0.0) run.duration_s = seconds;
  return felt_probes(run);
}

void halving(const PathOptions& options) {
  std::printf("steps half as long, windows of 50 ms from one state, firm hand on a recording; voxels of the finest field\n");
  std::printf("%-16s %10s %10s %9s %9s | %9s %9s %9s at tick | %7s %9s\n", "scene", "contact s", "identical", "compared",
              "left out", "p50", "p99", "max", "events", "per 10 s");
  for (const std::string& file : scene_files(options)) {
    const Halving h = measure_halving(load_still(file, options), recorded_probes(file, options, options.count));
    std::printf("%-16s %10.1f %10d %9d %9d | %9.2g %9.2g %9.2g %7d | %7d %9.2f", short_name(file).c_str(), h.contact_s,
                h.identical, h.compared, h.after_differing, h.p50_voxels, h.p99_voxels, h.max_voxels, h.worst_tick,
                h.differing_events, h.differing_per_10_s);
    for (std::size_t i = 0; i < std::min<std::size_t>(4, h.differing_ticks.size()); ++i)
      std::printf(" %d", h.differing_ticks[i]);
    std::printf("\n");
  }
}

void still(const PathOptions& options) {
  const int places = options.count > 0 ? options.count : 1000;
  std::printf("%d places; peak to peak, bound: 1 mN + (k + 2 pi 150 D) x the quantised probe's\n", places);
  std::printf("%-16s %-22s %9s %10s %10s | %16s %7s  %s\n", "scene", "hand", "contact", "p99 mN", "max mN", "beyond bound mN",
              "places", "worst at m");
  for (const std::string& file : scene_files(options)) {
    const Scene scene = load_still(file, options);
    const auto row = [&](const char* hand, const StillCase& wanted) {
      const Still s = measure_still(scene, wanted);
      std::printf("%-16s %-22s %9d %10.3g %10.3g | %16.3g %7d  %.4f %.4f %.4f\n", short_name(file).c_str(), hand, s.in_contact,
                  1e3 * s.force_p99_n, 1e3 * s.force_max_n, 1e3 * s.beyond_max_n, s.beyond, s.worst_m.x, s.worst_m.y,
                  s.worst_m.z);
    };
    row("fixed", {.places = places});
    row("tremor, 10 um", {.places = std::max(1, places / 4), .encoder_step_m = 10e-6, .tremor = true});
    row("tremor, 55 um", {.places = std::max(1, places / 4), .encoder_step_m = 55e-6, .tremor = true});
  }
}

namespace {

struct Base {
  std::string name;
  std::string toml;
  std::vector<std::string> scalars;  // NAME|LEVEL|SPAN
  std::vector<std::string> vectors;
};

std::vector<Base> bases(bool real) {
  const std::string vortex = "[volume.swirl]\nanalytic = \"lamb_oseen_vortex\"\nsampled = 64\n";
  if (!real) {
    return {{"head phantom",
             "[volume.head]\nanalytic = \"head_phantom\"\nsampled = 96\n[workspace]\nscale = 1.5\ncenter = \"head\"\n" + vortex,
             {"head|-300|600", "head|-300|600"},
             {"swirl"}},
            {"wing wake",
             "[volume.wing]\nanalytic = \"wing_wake\"\nsampled = 64\n[workspace]\nscale = 4\ncenter = [1.4, -1.2, 0]\n",
             {"wing.pressure|-0.06|0.03"},
             {"wing.velocity"}}};
  }
  return {
      {"head",
       "[volume.head]\nfile = \"ct_head_cranium/cranium.mhd\"\nlength_unit = \"mm\"\n[workspace]\nscale = 0.4\n"
       "center = [0.122, 0.193, 0.095]\ntowards_user = \"+y\"\nup = \"+z\"\n[volume.swirl]\nanalytic = \"lamb_oseen_vortex\"\n"
       "sampled = 64\npose = {translate_m = [0.122, 0.193, 0.095]}\n",
       {"head|-300|600"},
       {"swirl"}},
      {"flow",
       "[volume.flow]\nfile = \"mri_flow_carotid/carotid.vtk\"\nlength_unit = \"mm\"\nfields = {velocity = {array = "
       "\"vectors\", unit = \"cm/s\"}, signal = {array = \"scalars\"}}\n[workspace]\nscale = 0.06\ncenter = [0.1465, 0.0990, "
       "0.0280]\ntowards_user = \"+y\"\nup = \"+z\"\n",
       {"flow.signal|150|60"},
       {"flow.velocity"}},
      {"wing",
       "[volume.wing]\nfile = \"cfd_wing/wing.vti\"\nlength_unit = \"m\"\n[workspace]\nscale = 2\ncenter = [1.40, -1.45, "
       "0.09]\ntowards_user = \"-y\"\nup = \"+z\"\n",
       {"wing.pressure|-0.05|0.03"},
       {"wing.velocity"}}};
}

}  // namespace

void energy(const PathOptions& options) {
  const int ticks = options.count > 0 ? options.count : 100000;
  constexpr int rounds = 4;  // random combinations of each base
  const std::vector<Base> all = bases(!options.data_folder.empty());
  const int each = std::max(1, ticks / (rounds * static_cast<int>(all.size())));
  const VolumeReader read = volume_reader();
  std::map<std::string, Volume> known;
  const VolumeReader once = [&](const VolumeRequest& request) {
    const std::string key = request.files.empty() ? "" : request.files.front().string();
    const auto found = known.find(key);
    if (found != known.end()) return found->second;
    return known.emplace(key, read(request)).first->second;
  };
  std::printf("%-14s %9s %7s %10s %10s | %11s %7s | %11s %11s %11s %11s | %11s\n", "data", "ticks", "waiting", "sub-steps",
              "primitives", "brought in J", "beyond", "works J", "path J", "path > lim", "identity", "largest path");
  Random random(2026);
  for (const Base& base : all) {
    Booked booked;
    ClosedLoop loop;
    for (int round = 0; round < rounds; ++round) {
      const std::string toml = "palpa = 1\n[coupling]\nstiffness_n_per_m = " + std::to_string(random.uniform(200, 1500)) +
                               "\n" + base.toml + random_modes(random, base.scalars, base.vectors);
      const Scene scene = parse_scene(toml, base.name, options.data_folder, once, standard_modes()).scene;
      measure_booked(scene, each, 0.06, random, booked);
      measure_closed_loop(scene, each / 2, 0.06, random, loop);
    }
    std::printf("%-14s %9lld %7lld %10lld %10lld | %11.3g %7lld | %11.3g %11.3g %11.3g %11.3g | %11.3g\n", base.name.c_str(),
                static_cast<long long>(booked.ticks), static_cast<long long>(booked.waiting),
                static_cast<long long>(booked.sub_steps), static_cast<long long>(booked.primitives), booked.primitive_beyond_j,
                static_cast<long long>(booked.primitives_beyond), booked.works_differ_j, booked.path_differs_j,
                booked.path_beyond_j, booked.identity_differs_j, booked.largest_path_j);
    std::printf(
        "%-14s closed loop, b = kT/2 + D: %lld ticks, hand and spring gain at most %.3g J beyond the booked work; the arm "
        "moves %.3g J, modes bring in %.3g J, the path %.3g J\n",
        base.name.c_str(), static_cast<long long>(loop.ticks), loop.gained_j, loop.arm_work_j, loop.injected_j,
        loop.path_and_release_j);
  }
}

}  // namespace palpa::bench
