#include "palpa/study/recording.h"

#include <charconv>
#include <cmath>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/base/web_address.h"
#include "palpa/base/wording.h"
#include "palpa/data/volume.h"
#include "palpa/trace/windows.h"
#include "palpa/version.h"

namespace palpa::detail {
namespace {

/// Seeds of a simulated hand, from its description.
std::vector<std::uint64_t> seeds_of(const std::string& hand) {
  constexpr std::string_view key = "seed=";
  if (!hand.starts_with("sim:")) return {};
  const std::size_t at = hand.find(key);
  if (at == std::string::npos) return {default_hand_seed};
  std::uint64_t seed = 0;
  const char* first = hand.data() + at + key.size();
  if (std::from_chars(first, hand.data() + hand.size(), seed).ec != std::errc{}) return {};
  return {seed};
}

}  // namespace

std::vector<SourceFile> data_files(const Scene& scene) {
  std::vector<SourceFile> files;
  for (const SceneVolume& volume : scene.volumes()) {
    for (SourceFile file : volume.volume.files) {
      file.path = absolute_place(file.path).string();
      files.push_back(std::move(file));
    }
  }
  return files;
}

std::unique_ptr<TraceWriter> new_trace(const std::filesystem::path& folder, const TraceHeader& header,
                                       const std::string& scene_text, const Scene& scene) {
  std::vector<std::string> modes;
  for (const SceneMode& mode : scene.modes()) modes.push_back(mode.name);
  TraceHeader of_scene = header;
  of_scene.has_tool = !Tool(scene.tool(), scene.coupling()).is_point();
  std::vector<TracedField> octaves = traced_fields(scene);
  of_scene.has_octaves = !octaves.empty();
  return std::make_unique<TraceWriter>(folder, of_scene, scene_text, std::move(modes), std::move(octaves));
}

TraceHeader header_of(const RunOptions& options, const PreparedRun& prepared, const DeviceLimits& limits) {
  TraceHeader header;
  header.palpa_version = version;
  header.arguments = options.arguments;
  header.sets = options.scene_options.sets;
  if (is_one_of_several(header)) header.hand = options.hand;
  for (const std::filesystem::path& plugin : options.plugins)
    header.plugins.push_back(std::filesystem::absolute(plugin).lexically_normal().string());
  header.hand_to_world = prepared.loaded.scene.hand_to_world();
  header.dt_s = 1.0 / options.rate_hz;
  header.device_name = prepared.device;
  header.device_max_force_n = limits.max_force_n;
  header.device_max_stiffness_n_per_m = limits.max_stiffness_n_per_m;
  header.device_workspace_radius_m = limits.workspace_radius_m;
  header.device_encoder_step_m = limits.encoder_step_m;
  header.device_max_torque_nm = limits.max_torque_nm;
  header.device_max_turn_damping_nms_per_rad = limits.max_turn_damping_nms_per_rad;
  header.data_files = data_files(prepared.loaded.scene);
  header.seeds = seeds_of(options.hand);
  header.primitives = options.primitives;
  header.notes = prepared.notes;
  return header;
}

void hold_to(const DeviceLimits& limits, PreparedRun& prepared, TraceHeader& header) {
  const Scene scene = std::exchange(prepared.loaded.scene, clamped_to(prepared.loaded.scene, limits));
  for (const TakenLimit& limit : taken_limits(scene, prepared.loaded.scene)) {
    header.sets.emplace_back(limit.path, toml_number(limit.value));
    prepared.notes.push_back(limit.sentence);
    header.notes.push_back(limit.sentence);
  }
}

Recording::Recording(const RunOptions& options, const TraceHeader& header, const LoadedScene& loaded) {
  if (options.out.empty()) return;
  writer_ = new_trace(options.out, header, loaded.text, loaded.scene);
  recorder_ = std::make_unique<Recorder>(*writer_);
  is_of_point_ = Tool(loaded.scene.tool(), loaded.scene.coupling()).is_point();
}

void Recording::finish_ticks() {
  if (recorder_) recorder_->finish();
}

void Recording::finish() {
  if (writer_) writer_->finish();
}

void Recording::give_up() {
  recorder_.reset();
  writer_.reset();
}

GuardOptions guard_options_of(const TraceHeader& header) {
  GuardOptions options = guard_options_for({.max_force_n = header.device_max_force_n,
                                            .continuous_force_n = header.device_continuous_force_n,
                                            .max_damping_ns_per_m = header.device_max_damping_ns_per_m,
                                            .damping_ns_per_m = header.device_damping_ns_per_m,
                                            .max_torque_nm = header.device_max_torque_nm,
                                            .max_turn_damping_nms_per_rad = header.device_max_turn_damping_nms_per_rad},
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
