// Ticks per second of a scene under a hand, headless, with no trace.
//
//   bench_ticks SCENE HAND [rigid|relaxed|firm] [DATA_FOLDER]
//
// All figures come from one run of this program: the scene's ticks, the hand's with no mode enabled, and the scene's with
// evicted caches.
#include <palpa/loop/loop.h>
#include <palpa/palpa.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numeric>

#include "palpa/data/quantile.h"
#include "palpa/study/run.h"
#include "palpa/study/summary.h"
#include "palpa/trace/trace.h"
#include "run_arguments.h"

namespace {

using namespace palpa;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

struct Hand {
  std::vector<Probe> probes;
  double dt_s = 1e-3;
};

/// Seconds per tick of a fresh session, the best of three passes over the hand's path.
double seconds_per_tick(const Scene& scene, const Hand& hand) {
  double best_s = 1e9;
  for (int pass = 0; pass < 3; ++pass) {
    Session session(scene);
    const auto begin = Clock::now();
    for (const Probe& probe : hand.probes) session.tick(probe, hand.dt_s);
    best_s = std::min(best_s, seconds_since(begin) / static_cast<double>(hand.probes.size()));
  }
  return best_s;
}

/// Times of single ticks, spread over the path, each with evicted caches.
std::vector<double> cold_ticks_us(const Scene& scene, const Hand& hand) {
  std::vector<unsigned char> other(std::size_t{64} << 20);
  const std::size_t every = std::max<std::size_t>(1, hand.probes.size() / 300);
  std::vector<double> times_us;
  Session session(scene);
  for (std::size_t i = 0; i < hand.probes.size(); ++i) {
    const bool cold = i % every == 0;
    if (cold) {
      for (std::size_t byte = 0; byte < other.size(); byte += 64) ++other[byte];
    }
    const auto begin = Clock::now();
    session.tick(hand.probes[i], hand.dt_s);
    if (cold) times_us.push_back(1e6 * seconds_since(begin));
  }
  return times_us;
}

void measure(const RunOptions& options) {
  PreparedRun prepared = prepare(options);
  const Scene& scene = prepared.loaded.scene;

  Hand hand;
  std::vector<double> work;
  SummaryBuilder builder(scene);
  Session session(scene);
  const auto begin = Clock::now();
  run_simulated(session, *prepared.hand, {.rate_hz = options.rate_hz, .duration_s = prepared.duration_s}, nullptr,
                [&](const TickFrame& frame, const Session& felt) {
                  builder.add(frame, felt);
                  work.push_back(frame.result.work);
                  hand.probes.push_back({.position_m = frame.result.probe_m,
                                         .velocity_m_per_s = frame.result.probe_velocity_m_per_s,
                                         .valid = frame.result.probe_valid});
                  hand.dt_s = frame.dt_s;
                });
  const Summary summary = builder.finish(seconds_since(begin));
  if (hand.probes.empty()) throw LoadError("hand: shows nothing; give one that lasts longer");

  Scene empty = scene;
  for (const SceneMode& mode : scene.modes()) empty.edit_mode(mode.name, [](SceneMode& one) { one.enabled = false; });
  const double tick_s = seconds_per_tick(scene, hand);
  const double empty_s = seconds_per_tick(empty, hand);
  std::vector<double> cold_us = cold_ticks_us(scene, hand);
  const auto cold = [&](double share) { return detail::quantile(cold_us, share); };

  std::printf("scene        %s, hand %s\n", options.scene.c_str(), options.hand.c_str());
  for (const SceneMode& mode : scene.modes()) {
    std::printf("mode         %s (%s)\n", mode.name.c_str(), std::string(mode.mode.type()).c_str());
  }
  for (const SceneVolume& volume : scene.volumes()) {
    const bool formula = volume.volume.format == "formula";
    std::printf("volume       %s: %s, %s\n", volume.name.c_str(), volume.volume.format.c_str(),
                formula ? "no interpolant" : "trilinear");
  }
  std::printf("ticks        %zu, %.1f %% in contact, %.2f sub-steps each (at most %d)\n", hand.probes.size(),
              100.0 * summary.contact_share, summary.sub_steps_mean, summary.sub_steps_max);
  const auto units = [&](double share) { return detail::quantile(work, share); };
  std::printf("work         median %.0f, p99 %.0f, at most %.0f of the %d units of a tick\n", units(0.5), units(0.99),
              units(1.0), Session::most_work);
  std::printf("ticks/s      %.0f (%.2f us a tick)\n", 1.0 / tick_s, 1e6 * tick_s);
  std::printf("with hand    %.0f ticks/s, the loop with its simulated hand and this summary\n", summary.ticks_per_s);
  std::printf("empty scene  %.0f ticks/s (%.2f us a tick): a tick of the scene is %.1f of these\n", 1.0 / empty_s,
              1e6 * empty_s, tick_s / empty_s);
  std::printf("cold caches  p50 %.2f us, p99 %.2f us over %zu ticks: %.1f and %.1f warm ones\n", cold(0.50), cold(0.99),
              cold_us.size(), 1e-6 * cold(0.50) / tick_s, 1e-6 * cold(0.99) / tick_s);
}

}  // namespace

int main(int argc, char** argv) { return run_with_arguments(argc, argv, "bench_ticks", measure); }
