#include "palpa/study/run.h"

#include <signal.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>

#include "palpa/baseline/path.h"
#include "palpa/device/paced_hand.h"
#include "palpa/study/recording.h"
#include "palpa/version.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;

/// Whether the guard held back some of the force in more than a hundredth of the ticks.
bool often_limited(const Summary& summary) { return 100 * summary.guard_limited_ticks > summary.ticks; }
std::string words_of_limit(const Summary& summary) {
  char text[240];
  std::snprintf(text, sizeof text,
                "The hand pressed for %.1f N, of which %.1f N reached it: a recording goes its way whatever it meets, which no "
                "hand does. --hand-hold firm lets the data hold it.",
                summary.asked_force_max_n, summary.force_max_n);
  return text;
}

/// Places of a path, evenly spread in time however long it is: when there are too many, every other one is dropped.
class ThinnedPath {
 public:
  ThinnedPath() { places_m_.reserve(most); }
  void add(const Vec3& place_m) {
    if (seen_++ % stride_ != 0) return;
    places_m_.push_back(place_m);
    if (places_m_.size() < most) return;
    for (std::size_t n = 0; n < most / 2; ++n) places_m_[n] = places_m_[2 * n];
    places_m_.resize(most / 2);
    stride_ *= 2;
  }
  const std::vector<Vec3>& places_m() const { return places_m_; }

 private:
  static constexpr std::size_t most =
      2048;  // [1] places. More: the search for what is nearest to them is slower; fewer: coarser
  std::vector<Vec3> places_m_;
  std::int64_t seen_ = 0, stride_ = 1;
};

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

TraceHeader header_of(const RunOptions& options, const PreparedRun& prepared, const DeviceLimits& limits) {
  TraceHeader header;
  header.palpa_version = version;
  header.arguments = options.arguments;
  header.sets = options.scene_options.sets;
  for (const fs::path& plugin : options.plugins) header.plugins.push_back(fs::absolute(plugin).lexically_normal().string());
  header.hand_to_world = prepared.loaded.scene.hand_to_world();
  header.dt_s = 1.0 / options.rate_hz;
  header.device_name = prepared.device;
  header.device_max_force_n = limits.max_force_n;
  header.device_max_stiffness_n_per_m = limits.max_stiffness_n_per_m;
  header.device_workspace_radius_m = limits.workspace_radius_m;
  header.device_encoder_step_m = limits.encoder_step_m;
  header.data_files = detail::data_files(prepared.loaded.scene);
  header.seeds = seeds_of(options.hand);
  header.primitives = options.primitives;
  header.notes = prepared.notes;
  return header;
}

/// What a run tells of itself while it is felt and when it is over.
class Telling {
 public:
  Telling(const RunOptions& options, PreparedRun& prepared)
      : options_(options), prepared_(prepared), builder_(prepared.loaded.scene) {}

  /// Allocates nothing, but what `options.progress` does.
  void add(const TickFrame& frame, const Session& felt) {
    builder_.add(frame, felt);
    if (frame.result.probe_valid && is_finite(frame.result.probe_m)) path_.add(frame.result.probe_m);
    if (options_.progress && frame.tick % 1000 == 0) {
      const double before = prepared_.reach ? reach_progress : 0.0;
      options_.progress(before + (1.0 - before) * std::min(1.0, frame.t_s / prepared_.duration_s));
    }
  }
  /// \param writer  which the sentences go into as well; or nullptr
  Summary finish(double wall_s, TraceWriter* writer) {
    Summary summary = builder_.finish(wall_s);
    summary.notes = prepared_.notes;
    const auto note = [&](const std::string& sentence) {
      summary.notes.push_back(sentence);
      if (writer) writer->add_note(sentence);
    };
    if (prepared_.goes_its_own_way && often_limited(summary)) note(words_of_limit(summary));
    if (const double share = summary.contact_share; share < little_contact) {
      char lead[80] = "Nothing was felt.";
      if (share > 0.0) std::snprintf(lead, sizeof lead, "Little was felt: in %.1f %% of the ticks.", 100.0 * share);
      if (!prepared_.reach) prepared_.reach.emplace(prepared_.loaded.scene);
      note(lead + (" " + why_little_is_felt(*prepared_.reach, path_.places_m(), prepared_.remedy)));
    }
    return summary;
  }

 private:
  const RunOptions& options_;
  PreparedRun& prepared_;
  SummaryBuilder builder_;
  ThinnedPath path_;
};

/// The scene within what the device bears. What is changed is told, and set in the trace's scene as well.
void hold_to(const DeviceLimits& limits, PreparedRun& prepared, TraceHeader& header) {
  const CouplingOptions asked = std::exchange(prepared.loaded.scene, within(prepared.loaded.scene, limits)).coupling;
  const auto tell = [&](double wanted, double taken, const char* key, const char* unit) {
    if (wanted == taken) return;
    char number[40], text[200];
    std::snprintf(number, sizeof number, "%.17g", taken);
    std::snprintf(text, sizeof text, "coupling.%s: the scene has %g %s, the device bears %g %s; that is taken.", key, wanted,
                  unit, taken, unit);
    header.sets.emplace_back(std::string("coupling.") + key, number);
    prepared.notes.push_back(text);
    header.notes.push_back(text);
  };
  const CouplingOptions& held = prepared.loaded.scene.coupling;
  tell(asked.stiffness_n_per_m, held.stiffness_n_per_m, "stiffness_n_per_m", "N/m");
  tell(asked.damping_ns_per_m, held.damping_ns_per_m, "damping_ns_per_m", "N·s/m");
}

/// The trace of a run; nothing where none is wanted.
class Recording {
 public:
  Recording(const RunOptions& options, const TraceHeader& header, const LoadedScene& loaded) {
    if (options.out.empty()) return;
    writer_ = detail::new_trace(options.out, header, loaded.text, loaded.scene);
    recorder_ = std::make_unique<Recorder>(*writer_);
  }
  Recorder* recorder() const { return recorder_.get(); }
  TraceWriter* writer() const { return writer_.get(); }
  void finish_ticks() {
    if (recorder_) recorder_->finish();
  }
  void finish() {
    if (writer_) writer_->finish();
  }
  /// What was recorded stays; no more is.
  void give_up() {
    recorder_.reset();
    writer_.reset();
  }

 private:
  std::unique_ptr<TraceWriter> writer_;
  std::unique_ptr<Recorder> recorder_;
};

/// Feels the scene in real time on a thread of its own, while this one watches.
void feel_live(const LiveRunOptions& options, LiveLoop& loop, LiveScene& scene, const TickObserver& observer,
               const std::atomic<bool>* stop, std::vector<std::string>& warnings) {
  // Longer: a panic key is heard later; shorter: more work.
  constexpr auto watch_interval = std::chrono::milliseconds(20);
  std::atomic<bool> ends{false}, ended{false};
  std::vector<std::string> refused;
  // An interrupt is for the watching thread.
  sigset_t all, before;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread felt([&] {
    {
      const RealTimeThread real_time;
      refused = real_time.refused();
      loop.run(ends, observer);
    }
    ended = true;
  });
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  try {
    while (!ended) {
      std::this_thread::sleep_for(watch_interval);
      if ((stop && *stop) || (options.watch && !options.watch(loop, scene))) ends = true;
    }
  } catch (...) {
    ends = true;  // first of all the motors
    felt.join();
    throw;
  }
  felt.join();
  warnings.insert(warnings.end(), refused.begin(), refused.end());
}

RunResult run_live(const RunOptions& options, PreparedRun& prepared, const std::atomic<bool>* stop) {
  std::optional<PacedHand> paced;
  if (prepared.hand) paced.emplace(*prepared.hand);
  Device& device = paced ? static_cast<Device&>(*paced) : *prepared.real_device;
  const DeviceLimits limits = device.limits();
  const LiveRunOptions& live = *options.live;

  TraceHeader header = header_of(options, prepared, limits);
  hold_to(limits, prepared, header);
  LiveOptions loop_options{.rate_hz = options.rate_hz,
                           .duration_s = prepared.duration_s,
                           .rehearse = live.rehearse,
                           .guard = guard_options_for(limits, prepared.loaded.scene.coupling.max_force_n),
                           .clutch_buttons = live.clutch_buttons,
                           .goes_on_at_border = live.goes_on_at_border};
  loop_options.guard.dead_man_buttons = live.dead_man_buttons;
  header.motors = true;
  header.device_continuous_force_n = limits.continuous_force_n;
  header.device_max_damping_ns_per_m = limits.max_damping_ns_per_m;
  header.device_damping_ns_per_m = limits.damping_ns_per_m;
  header.dead_man_buttons = live.dead_man_buttons;

  RunResult result;
  Recording recording(options, header, prepared.loaded);
  Telling telling(options, prepared);
  LiveScene scene(prepared.loaded.scene, baseline::path, limits);
  LiveLoop loop(scene, device, loop_options, recording.recorder());
  const auto begin = std::chrono::steady_clock::now();
  feel_live(
      live, loop, scene, [&](const TickFrame& frame, const Session& felt) { telling.add(frame, felt); }, stop, result.warnings);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;

  const auto lose = [&](const std::exception& error) {
    result.is_recording_lost = true;
    result.warnings.push_back(std::string(error.what()) +
                              "; the run went on without its recording, of which what was written "
                              "before stays");
    recording.give_up();
  };
  try {
    recording.finish_ticks();
  } catch (const std::exception& error) {
    lose(error);
  }
  result.summary = telling.finish(wall.count(), recording.writer());
  result.summary.loop = loop.account();
  try {
    recording.finish();
  } catch (const std::exception& error) {
    lose(error);
  }
  return result;
}

RunResult run_on_simulated_clock(const RunOptions& options, PreparedRun& prepared, const std::atomic<bool>* stop) {
  const DeviceLimits limits = prepared.hand->limits();
  Session session(prepared.loaded.scene, baseline::path, limits.encoder_step_m);
  Recording recording(options, header_of(options, prepared, limits), prepared.loaded);
  Telling telling(options, prepared);
  const LoopOptions loop{.rate_hz = options.rate_hz, .duration_s = prepared.duration_s};
  const auto begin = std::chrono::steady_clock::now();
  run_simulated(
      session, *prepared.hand, loop, recording.recorder(),
      [&](const TickFrame& frame, const Session& felt) { telling.add(frame, felt); }, stop);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  recording.finish_ticks();
  RunResult result;
  result.summary = telling.finish(wall.count(), recording.writer());
  recording.finish();
  return result;
}

}  // namespace

RunResult run(const RunOptions& options, const std::atomic<bool>* stop) {
  PreparedRun prepared = prepare(options);
  RunResult result = options.live ? run_live(options, prepared, stop) : run_on_simulated_clock(options, prepared, stop);
  std::vector<std::string>& warnings = result.warnings;
  warnings.insert(warnings.begin(), prepared.loaded.warnings.begin(), prepared.loaded.warnings.end());
  result.interrupted = stop && stop->load();
  return result;
}

}  // namespace palpa
