// Scenes and hands of bench_felt.
#include <palpa/file/read_volume.h>
#include <palpa/scene/first_scene.h>

#include <algorithm>

#include "bench/felt.h"
#include "palpa/device/front.h"
#include "palpa/device/hand.h"
#include "palpa/study/reach.h"

namespace palpa::bench {
namespace {

/// Suggested scenes of files: floats with padding, floats, integers with trailing zeros, integers, a flow in part of its box.
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
                 const std::filesystem::path& data_folder, const std::filesystem::path& in_place_folder) {
  SceneOptions options;
  options.data_folders = {data_folder};
  for (const Suggested& one : suggested) {
    if (name != one.name) continue;
    const std::filesystem::path in_place = in_place_folder / (name + ".toml");
    if (!in_place_folder.empty() && std::filesystem::exists(in_place)) {
      origin = in_place.filename().string() + " in place of the suggested scene";
      return load_scene(in_place, volume_reader(), standard_modes(), options);
    }
    VolumeRequest request;
    request.files = {data_folder / one.file};
    origin = std::string("suggested for ") + one.file;
    return parse_scene(first_scene(read_volume(request), request), name, data_folder, volume_reader(), standard_modes());
  }
  origin = "scenes/" + name + ".toml";
  return load_scene(scenes_folder / (name + ".toml"), volume_reader(), standard_modes(), options);
}

}  // namespace

std::vector<std::string> felt_scene_names() {
  std::vector<std::string> names(std::begin(shipped), std::end(shipped));
  for (const Suggested& one : suggested) names.emplace_back(one.name);
  return names;
}

FeltScene load_felt_scene(const std::string& name, const std::filesystem::path& scenes_folder,
                          const std::filesystem::path& data_folder, const std::filesystem::path& in_place_folder) {
  std::string origin;
  const Scene scene = load(name, origin, scenes_folder, data_folder, in_place_folder).scene;
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

double press_duration_s(const Encounter& met, double speed_m_per_s) { return (met.before_m + press_depth_m) / speed_m_per_s; }

std::shared_ptr<const Target> press_at(const Encounter& met, double u_m, double v_m, double speed_m_per_s) {
  const Vec3 begin_m = met.facing->at(u_m, v_m, -met.before_m);
  return path_target(
      [=](double t_s) {
        return begin_m - Vec3{0.0, 0.0, speed_m_per_s * t_s};
      },
      press_duration_s(met, speed_m_per_s));
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
