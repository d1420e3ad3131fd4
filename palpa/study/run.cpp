#include "palpa/study/run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
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

RunResult run_live(const RunOptions& options, PreparedRun& prepared, const std::atomic<bool>* stop) {
  // Longer: a panic key acts later; shorter: more work.
  constexpr auto watch_interval = std::chrono::milliseconds(20);
  std::optional<PacedHand> paced;
  if (prepared.hand) paced.emplace(*prepared.hand);
  Device& device = paced ? static_cast<Device&>(*paced) : *prepared.real_device;
  Telling telling(options, prepared);
  LiveRun live(options, prepared, device, [&](const TickFrame& frame, const Session& felt) { telling.add(frame, felt); });
  while (!live.has_ended()) {
    std::this_thread::sleep_for(watch_interval);
    if ((stop && *stop) || (options.live->watch && !options.live->watch(live.loop(), live.scene()))) live.end();
  }
  live.end();
  RunResult result;
  result.warnings = live.refused();
  result.summary = telling.finish(live.wall_s(), live.recording().writer());
  result.summary.loop = live.loop().statistics();
  if (const std::string lost = live.finish(); !lost.empty()) {
    result.is_recording_lost = true;
    result.warnings.push_back(lost);
  }
  return result;
}

/// Duration of the loop: ticks begin before it. So n rows, a tick apart, give n ticks.
double loop_duration_s(const PreparedRun& prepared, double rate_hz) {
  if (!prepared.ends_with_row) return prepared.duration_s;
  constexpr double rounding_ticks = 1e-6;  // of times in decimals. More: a tick after the end; less: the last row is missed
  return (std::floor(prepared.duration_s * rate_hz + rounding_ticks) + 1.0) / rate_hz;
}

RunResult run_on_simulated_clock(const RunOptions& options, PreparedRun& prepared, const std::atomic<bool>* stop) {
  const DeviceLimits limits = prepared.hand->limits();
  Session session(prepared.loaded.scene, limits.encoder_step_m);
  detail::Recording recording(options, detail::header_of(options, prepared, limits), prepared.loaded);
  Telling telling(options, prepared);
  const LoopOptions loop{.rate_hz = options.rate_hz, .duration_s = loop_duration_s(prepared, options.rate_hz)};
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

RunResult run(const RunOptions& options, const std::atomic<bool>* stop) { return run(prepare(options), options, stop); }

RunResult run(PreparedRun prepared, const RunOptions& options, const std::atomic<bool>* stop) {
  RunResult result = options.live ? run_live(options, prepared, stop) : run_on_simulated_clock(options, prepared, stop);
  std::vector<std::string>& warnings = result.warnings;
  warnings.insert(warnings.begin(), prepared.loaded.warnings.begin(), prepared.loaded.warnings.end());
  result.interrupted = stop && stop->load();
  return result;
}

}  // namespace palpa
