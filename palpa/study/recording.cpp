#include "palpa/study/recording.h"

#include <cmath>

#include "palpa/volume/volume.h"

namespace palpa::detail {

std::vector<SourceFile> data_files(const Scene& scene) {
  std::vector<SourceFile> files;
  for (const SceneVolume& volume : scene.volumes()) {
    for (SourceFile file : volume.volume.files) {
      file.path = std::filesystem::absolute(file.path).string();
      files.push_back(std::move(file));
    }
  }
  return files;
}

std::unique_ptr<TraceWriter> new_trace(const std::filesystem::path& folder, const TraceHeader& header,
                                       const std::string& scene_text, const Scene& scene) {
  std::vector<std::string> modes;
  for (const SceneMode& mode : scene.modes()) modes.push_back(mode.name);
  return std::make_unique<TraceWriter>(folder, header, scene_text, std::move(modes));
}

GuardOptions guard_options_of(const TraceHeader& header) {
  GuardOptions options = guard_options_for({.max_force_n = header.device_max_force_n,
                                            .continuous_force_n = header.device_continuous_force_n,
                                            .max_damping_ns_per_m = header.device_max_damping_ns_per_m,
                                            .damping_ns_per_m = header.device_damping_ns_per_m},
                                           header.device_max_force_n);
  options.motors = header.motors;
  options.dead_man_buttons = header.dead_man_buttons;
  return options;
}

std::string what_cannot_be_felt_again(const TickFrame* before, const TickFrame& recorded, double nominal_dt_s) {
  if (!before) return {};
  const std::string place = "tick " + std::to_string(recorded.tick);
  if ((recorded.circumstances & bit_of(Circumstance::new_scene)) != 0)
    return place + ": another scene was felt from here on, which is not in the trace";
  if (std::lround(recorded.dt_s / nominal_dt_s) < recorded.tick - before->tick)
    return place + ": the ticks before it were not recorded";
  return {};
}

}  // namespace palpa::detail
