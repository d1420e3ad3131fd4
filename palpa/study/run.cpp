#include "palpa/study/run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <span>
#include <thread>

#include "palpa/base/printed.h"
#include "palpa/device/paced_hand.h"
#include "palpa/study/live_run.h"
#include "palpa/study/recording.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;

/// Whether the guard limited the force in more than a hundredth of the ticks.
bool often_limited(const Summary& summary) { return 100 * summary.guard_limited_ticks > summary.ticks; }
std::string format_limit(const Summary& summary) {
  return detail::text(
      "The coupling requested up to %.1f N, of which %.1f N reached the hand: a rigid recording does not give way, as a hand "
      "does. --hand-hold firm lets the force move it.",
      summary.asked_force_max_n, summary.force_max_n);
}

/// Positions of a path, evenly spread in time at any length: above the maximum, every other one is dropped.
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
      2048;  // [1] positions. More: the search for the nearest contact is slower; fewer: coarser
  std::vector<Vec3> places_m_;
  std::int64_t seen_ = 0, stride_ = 1;
};

/// Reporting of a run, during and after it.
class Telling {
 public:
  Telling(const RunOptions& options, PreparedRun& prepared)
      : options_(options), prepared_(prepared), builder_(prepared.loaded.scene) {}

  /// Allocates nothing, except by `options.progress`.
  void add(const TickFrame& frame, const Session& felt) {
    builder_.add(frame, felt);
    if (frame.result.probe_valid && is_finite(frame.result.probe_m)) path_.add(frame.result.probe_m);
    if (options_.progress && frame.tick % 1000 == 0) {
      const double before = prepared_.reach ? reach_progress : 0.0;
      options_.progress(before + (1.0 - before) * std::min(1.0, frame.t_s / prepared_.duration_s));
    }
  }
  /// \param writer  receives the sentences as well; or nullptr
  Summary finish(double wall_s, TraceWriter* writer) {
    Summary summary = builder_.finish(wall_s);
    summary.notes = prepared_.notes;
    const auto note = [&](const std::string& sentence) {
      summary.notes.push_back(sentence);
      if (writer) writer->add_note(sentence);
    };
    if (prepared_.is_rigid_hand && often_limited(summary)) note(format_limit(summary));
    if (summary.unfelt_j > told_unfelt_j)
      note(
          detail::text("Turning the handle brought in %.1f mJ that no motor resists: the device senses turns and drives no "
                       "torque against them.",
                       1e3 * summary.unfelt_j));
    if (const double share = summary.contact_share; share < little_contact) {
      const std::string lead =
          share > 0.0 ? detail::text("Little was felt: in %.1f %% of the ticks.", 100.0 * share) : "Nothing was felt.";
      if (!prepared_.reach) prepared_.reach.emplace(prepared_.loaded.scene);
      note(lead + " " + explain_little_contact(*prepared_.reach, path_.places_m(), prepared_.remedy));
    }
    return summary;
  }

 private:
  const RunOptions& options_;
  PreparedRun& prepared_;
  SummaryBuilder builder_;
  ThinnedPath path_;
};

/// Runs hands in real time; `options` and `prepared` have one for each.
std::vector<RunResult> run_live(std::span<const RunOptions> options, std::span<PreparedRun> prepared,
                                const std::atomic<bool>* stop) {
  // Longer: a panic key acts later; shorter: more work.
  constexpr auto watch_interval = std::chrono::milliseconds(20);
  std::vector<std::unique_ptr<PacedHand>> paced;
  std::vector<LiveRunHand> hands;
  std::vector<std::unique_ptr<Telling>> telling;
  for (std::size_t h = 0; h < options.size(); ++h) {
    Device* device = prepared[h].real_device.get();
    if (prepared[h].hand) device = paced.emplace_back(std::make_unique<PacedHand>(*prepared[h].hand)).get();
    hands.push_back({&options[h], &prepared[h], device});
    telling.push_back(std::make_unique<Telling>(options[h], prepared[h]));
  }
  const HandObserver& observer = options.front().live->observer;
  LiveRun live(hands, [&](std::size_t hand, const TickFrame& frame, const Session& felt) {
    telling[hand]->add(frame, felt);
    if (observer) observer(hand, frame, felt);
  });
  std::vector<LiveScene*> scenes;
  for (std::size_t h = 0; h < options.size(); ++h) scenes.push_back(&live.scene(h));
  const auto& watch = options.front().live->watch;
  while (!live.has_ended()) {
    std::this_thread::sleep_for(watch_interval);
    if ((stop && *stop) || (watch && !watch(live.loop(), scenes))) live.end();
  }
  live.end();
  std::vector<RunResult> results(options.size());
  results.front().warnings = live.refused();
  for (std::size_t h = 0; h < options.size(); ++h) {
    TraceWriter* const writer = live.recording(h).writer();
    results[h].summary = telling[h]->finish(live.wall_s(), writer);
    results[h].summary.loop = live.loop().statistics(h);
    for (const std::string& note : results[h].summary.loop->windows.notes) {
      results[h].warnings.push_back(note);
      if (writer) writer->add_note(note);
    }
  }
  if (const std::string lost = live.finish(); !lost.empty()) {
    results.front().is_recording_lost = true;
    results.front().warnings.push_back(lost);
  }
  return results;
}

/// Duration of the loop: ticks begin before it. So n rows, a tick apart, give n ticks.
double loop_duration_s(const PreparedRun& prepared, double rate_hz) {
  if (!prepared.ends_with_row) return prepared.duration_s;
  constexpr double rounding_ticks = 1e-6;  // of times in decimals. More: a tick after the end; less: the last row is missed
  return (std::floor(prepared.duration_s * rate_hz + rounding_ticks) + 1.0) / rate_hz;
}

/// Sentences about chunks that are lost or damaged, of all fields of a store once.
std::vector<std::string> problems_of(const Stock& stock) {
  std::vector<std::string> all;
  for (std::size_t n = 0; n < stock.size(); ++n) {
    for (const std::string& sentence : stock.octaves(n).shape().source->problems_from(0))
      if (std::ranges::find(all, sentence) == all.end()) all.push_back(sentence);
  }
  return all;
}

std::vector<RunResult> run_on_simulated_clock(std::span<const RunOptions> options, std::span<PreparedRun> prepared,
                                              const std::atomic<bool>* stop) {
  std::vector<std::unique_ptr<Session>> sessions;
  std::vector<detail::Recording> recordings;
  std::vector<std::unique_ptr<Telling>> telling;
  std::vector<SimulatedHand> hands;
  LoopOptions loop{.rate_hz = options.front().rate_hz, .duration_s = 0.0};
  for (std::size_t h = 0; h < options.size(); ++h) {
    const DeviceLimits limits = prepared[h].hand->limits();
    sessions.push_back(std::make_unique<Session>(prepared[h].loaded.scene, limits.encoder_step_m));
    recordings.emplace_back(options[h], detail::header_of(options[h], prepared[h], limits), prepared[h].loaded);
    telling.push_back(std::make_unique<Telling>(options[h], prepared[h]));
    hands.push_back({sessions[h].get(), prepared[h].hand.get(), recordings[h].recorder()});
    loop.duration_s = std::max(loop.duration_s, loop_duration_s(prepared[h], loop.rate_hz));
  }
  const auto begin = std::chrono::steady_clock::now();
  run_simulated(
      hands, loop, [&](std::size_t h, const TickFrame& frame, const Session& felt) { telling[h]->add(frame, felt); }, stop);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  std::vector<RunResult> results(options.size());
  for (std::size_t h = 0; h < options.size(); ++h) {
    recordings[h].finish_ticks();
    TraceWriter* const writer = recordings[h].writer();
    results[h].summary = telling[h]->finish(wall.count(), writer);
    for (const std::string& problem : problems_of(sessions[h]->stock())) {
      results[h].warnings.push_back(problem);
      if (writer) writer->add_note(problem);
    }
    recordings[h].finish();
  }
  return results;
}

std::vector<RunResult> run_all(std::span<const RunOptions> options, std::span<PreparedRun> prepared,
                               const std::atomic<bool>* stop) {
  std::vector<RunResult> results =
      options.front().live ? run_live(options, prepared, stop) : run_on_simulated_clock(options, prepared, stop);
  for (std::size_t h = 0; h < results.size(); ++h) {
    std::vector<std::string>& warnings = results[h].warnings;
    warnings.insert(warnings.begin(), prepared[h].loaded.warnings.begin(), prepared[h].loaded.warnings.end());
    results[h].interrupted = stop && stop->load();
  }
  return results;
}

}  // namespace

RunResult run(const RunOptions& options, const std::atomic<bool>* stop) { return run(prepare(options), options, stop); }

RunResult run(PreparedRun prepared, const RunOptions& options, const std::atomic<bool>* stop) {
  return std::move(run_all({&options, 1}, {&prepared, 1}, stop).front());
}

std::vector<RunResult> run_hands(PreparedHands prepared, const std::atomic<bool>* stop) {
  const fs::path folder = prepared.options.front().out.parent_path();
  std::error_code error;
  if (!folder.empty() && !fs::create_directory(folder, error)) {
    throw LoadError(folder.string() + ": the folder of the traces cannot be made; choose another, new one");
  }
  return run_all(prepared.options, prepared.runs, stop);
}

}  // namespace palpa
