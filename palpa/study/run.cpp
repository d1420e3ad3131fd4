#include "palpa/study/run.h"

#include <unistd.h>

#include <charconv>
#include <chrono>
#include <cmath>
#include <system_error>

#include "palpa/baseline/law.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/plugin.h"
#include "palpa/study/recording.h"
#include "palpa/version.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;

constexpr double default_duration_s = 10.0;

void check_numbers(const RunOptions& options) {
  if (!(options.rate_hz >= 1.0 && options.rate_hz <= 1e5)) {
    throw LoadError("rate: " + std::to_string(options.rate_hz) + " Hz cannot be used; a rate lies between 1 and 100000 Hz");
  }
  if (options.duration_s && !(*options.duration_s > 0.0 && std::isfinite(*options.duration_s))) {
    throw LoadError("duration: " + std::to_string(*options.duration_s) + " s cannot be used; a duration is finite and above 0");
  }
}

/// That the trace's folder can be made, before a long load; `TraceWriter` has the last word.
void check_out(const fs::path& out) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(out, error))) {
    throw LoadError(out.string() + ": exists already; a trace goes into a new folder");
  }
  const fs::path parent = fs::absolute(out).lexically_normal().parent_path();
  if (!fs::is_directory(parent, error)) {
    throw LoadError(out.string() + ": the folder " + parent.string() + " does not exist; make it first");
  }
  if (::access(parent.c_str(), W_OK | X_OK) != 0) {
    throw LoadError(out.string() + ": the folder " + parent.string() + " cannot be written; choose another");
  }
}

/// The seeds of a simulated hand, from its description.
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

PreparedRun prepare(const RunOptions& options) {
  check_numbers(options);
  if (options.hand.empty()) {
    throw LoadError("hand: none was named; give a recording or sim:press|stroke|circle|helix|random");
  }
  if (!options.out.empty()) check_out(options.out);

  std::unique_ptr<SimulatedDevice> hand = open_hand(options.hand, options.hold, options.recording);
  const double hand_s = hand->duration_s();
  const double duration_s = options.duration_s.value_or(std::isfinite(hand_s) ? hand_s : default_duration_s);
  ReadOptions read = options.read;
  read.checksums = !options.out.empty();
  return {.loaded = load_scene(options.scene, volume_reader(read), modes_with(options.plugins), options.scene_options),
          .hand = std::move(hand),
          .duration_s = duration_s};
}

RunResult run(const RunOptions& options, const std::atomic<bool>* stop) {
  PreparedRun prepared = prepare(options);
  const Scene& scene = prepared.loaded.scene;
  const DeviceLimits limits = prepared.hand->limits();
  Session session(scene, baseline::law(scene), limits.encoder_step_m);

  std::unique_ptr<TraceWriter> writer;
  std::unique_ptr<Recorder> recorder;
  if (!options.out.empty()) {
    TraceHeader header;
    header.palpa_version = version;
    header.arguments = options.arguments;
    header.sets = options.scene_options.sets;
    for (const fs::path& plugin : options.plugins) header.plugins.push_back(fs::absolute(plugin).lexically_normal().string());
    header.hand_to_world = session.hand_to_world();
    header.dt_s = 1.0 / options.rate_hz;
    header.device_max_force_n = limits.max_force_n;
    header.device_max_stiffness_n_per_m = limits.max_stiffness_n_per_m;
    header.device_workspace_radius_m = limits.workspace_radius_m;
    header.device_encoder_step_m = limits.encoder_step_m;
    header.data_files = detail::data_files(scene);
    header.seeds = seeds_of(options.hand);
    header.primitives = options.primitives;
    writer = detail::new_trace(options.out, header, prepared.loaded.text, scene);
    recorder = std::make_unique<Recorder>(*writer);
  }

  SummaryBuilder builder(scene);
  const LoopOptions loop{.rate_hz = options.rate_hz, .duration_s = prepared.duration_s};
  const TickObserver observer = [&](const TickFrame& frame, const Session& felt) {
    builder.add(frame, felt);
    if (options.progress && frame.tick % 1000 == 0) options.progress(std::min(1.0, frame.t_s / prepared.duration_s));
  };
  const auto begin = std::chrono::steady_clock::now();
  run_simulated(session, *prepared.hand, loop, recorder.get(), observer, stop);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;

  if (recorder) recorder->finish();
  if (writer) writer->finish();

  RunResult result;
  result.summary = builder.finish(wall.count());
  result.warnings = std::move(prepared.loaded.warnings);
  result.interrupted = stop && stop->load();
  return result;
}

}  // namespace palpa
