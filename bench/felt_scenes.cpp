// The scenes and the hands of bench_felt.
#include <palpa/file/read_volume.h>
#include <palpa/first/first_scene.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/felt.h"
#include "palpa/baseline/path.h"
#include "palpa/device/front.h"
#include "palpa/device/hand.h"
#include "palpa/loop/loop.h"
#include "palpa/study/reach.h"

namespace palpa::bench {
namespace {

/// Scenes that are suggested for files: floats that end in padding, floats, whole numbers that end in zeros, whole numbers,
/// a flow on a grid that fills its box only in part.
struct Suggested {
  const char* name;
  const char* file;
};
constexpr Suggested suggested[] = {{"vessels", "mra_avf_nrrd/avf_float_32.nrrd"},
                                   {"storm", "weather_isabel/isabel_30.vti"},
                                   {"brain", "mri_flair_nrrd/FLAIR.nrrd"},
                                   {"protein", "mol_ironprot/ironProt.vtk"},
                                   {"combustor", "cfd_combustor/combxyz.bin"}};
constexpr const char* shipped[] = {"head", "many", "wing", "flow"};

LoadedScene load(const std::string& name, std::string& origin, const std::filesystem::path& scenes_folder,
                 const std::filesystem::path& data_folder) {
  for (const Suggested& one : suggested) {
    if (name != one.name) continue;
    VolumeRequest request;
    request.files = {data_folder / one.file};
    origin = std::string("suggested for ") + one.file;
    return parse_scene(first_scene(read_volume(request), request), name, data_folder, volume_reader(), standard_modes());
  }
  SceneOptions options;
  options.data_folders = {data_folder};
  origin = "scenes/" + name + ".toml";
  return load_scene(scenes_folder / (name + ".toml"), volume_reader(), standard_modes(), options);
}

class Path final : public Target {
 public:
  Path(std::function<Vec3(double)> at, double duration_s) : at_(std::move(at)), duration_s_(duration_s) {}
  Point at(double time_s) const noexcept override { return {.position_m = at_(time_s)}; }
  double duration_s() const noexcept override { return duration_s_; }

 private:
  std::function<Vec3(double)> at_;
  double duration_s_;
};

/// From 0 to 1 with two continuous derivatives.
double ease(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

// Of every hand here: in to the front, and a rest there. Slowly at the end, so that no arm runs through a level.
constexpr double approach_s = 1.6, rest_s = 0.6;
double depth_at(const Encounter& met, double depth_m, double t_s) {
  const double left = 1.0 - ease(t_s / approach_s);
  return depth_m - (depth_m + met.before_m) * left * left;
}

}  // namespace

std::vector<std::string> felt_scene_names() {
  std::vector<std::string> names(std::begin(shipped), std::end(shipped));
  for (const Suggested& one : suggested) names.emplace_back(one.name);
  return names;
}

FeltScene load_felt_scene(const std::string& name, const std::filesystem::path& scenes_folder,
                          const std::filesystem::path& data_folder) {
  std::string origin;
  const Scene scene = load(name, origin, scenes_folder, data_folder).scene;
  const Reach reach(scene);
  if (reach.is_empty()) throw LoadError(name + ": has nothing within reach of a hand; give another scene");
  const SimulatedMotion motion{.kind = SimulatedMotion::Kind::stroke};
  const Field& first = *scene.volumes().front().volume.fields.front().field;
  return {.name = name,
          .origin = origin,
          .scene = scene,
          .rigid = reach.encounter(motion, Hold::rigid),
          .held = reach.encounter(motion, Hold::relaxed),
          .edges = EdgesOfData(scene),
          .spacing_m = scene.hand_to_world().length_to_hand(first.spacing_m())};
}

std::shared_ptr<const Target> path_target(std::function<Vec3(double)> at, double duration_s) {
  return std::make_shared<Path>(std::move(at), duration_s);
}

Slide slide_over(const Encounter& met, double turn, double beside_m, double depth_m) {
  constexpr double begin_s = approach_s + rest_s, ramp_s = 0.1, settle_s = 0.05, least_half_m = 0.02;
  const double half_m = std::max(met.radius_m, least_half_m);
  const double to_s = begin_s + ramp_s / 2.0 + 2.0 * half_m / slide_m_per_s;
  const double u = std::cos(2.0 * std::numbers::pi * turn), v = std::sin(2.0 * std::numbers::pi * turn);
  return {.target = path_target(
              [=, front = met.facing](double t_s) {
                const double since_s = std::max(0.0, t_s - begin_s), s = std::min(1.0, since_s / ramp_s);
                const double gone_s = since_s < ramp_s ? ramp_s * s * s * s * (1.0 - 0.5 * s) : since_s - ramp_s / 2.0;
                const double along_m = slide_m_per_s * gone_s - half_m;
                return front->at(u * along_m - v * beside_m, v * along_m + u * beside_m, depth_at(met, depth_m, t_s));
              },
              to_s),
          .from_s = begin_s + ramp_s + settle_s,
          .to_s = to_s};
}

std::shared_ptr<const Target> hold_at(const Encounter& met, double beside_m, double depth_m, const Tremor& tremor,
                                      double duration_s) {
  return path_target(
      [=, front = met.facing](double t_s) {
        const double sway_m = tremor.amplitude_m * ease((t_s - approach_s) / rest_s) *
                              std::sin(2.0 * std::numbers::pi * tremor.frequency_hz * (t_s - approach_s));
        return front->at(beside_m, 0.0, depth_at(met, depth_m, t_s)) + Vec3{0.0, 0.0, sway_m};
      },
      duration_s);
}

double press_duration_s(const Encounter& met, double speed_m_per_s) { return (met.before_m + press_depth_m) / speed_m_per_s; }

std::shared_ptr<const Target> press_at(const Encounter& met, double u_m, double v_m, double speed_m_per_s) {
  const Vec3 begin_m = met.facing->at(u_m, v_m, -met.before_m);
  return path_target(
      [=](double t_s) {
        return begin_m - Vec3{0.0, 0.0, speed_m_per_s * t_s};
      },
      press_duration_s(met, speed_m_per_s));
}

FeltRun feel(const Scene& scene, SimulatedDevice& device, double duration_s) {
  Session session(scene, baseline::path, device.limits().encoder_step_m);
  FeltRun run = felt_run(scene);
  run_simulated(session, device, {.rate_hz = rate_hz, .duration_s = duration_s, .time_ticks = false}, nullptr,
                [&](const TickFrame& frame, const Session& felt) { add_tick(run, frame, felt); });
  return run;
}

FeltRun feel(const Scene& scene, const std::shared_ptr<const Target>& target, double duration_s, const DevicePlant& plant) {
  const auto hand = hand_device(target, Hold::rigid, plant);
  return feel(scene, *hand, duration_s);
}

std::vector<DevicePlant> device_plants() {
  std::vector<DevicePlant> plants;
  for (const char* name : {"touch", "omega", "falcon", "inverse3", "desktop"}) plants.push_back(device_plant(name));
  for (DevicePlant& plant : plants) plant.delay_ticks = 1;
  return plants;
}

}  // namespace palpa::bench
