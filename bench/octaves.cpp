// Octaves that hands would feel of a large store, in virtual time, and ticks of windows beside those of a grid in memory:
//
//   bench_octaves HAND... [--quick]
//   bench_octaves ticks SCENE VOLUME HAND
//
// HAND: a recording, or sim:random. 4096³ voxels in chunks of 32³, of which a voxel is 36.6, 146 or 2340 µm of the hand; mean
// speeds of 0.01 to 3 m/s; chunks from memory, a disk, and two networks. Compare with the table of docs/large.md.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/device/hand.h"
#include "palpa/loop/window_feed.h"
#include "palpa/study/octave_forecast.h"
#include "palpa/study/run.h"

namespace {

using namespace palpa;

constexpr double longest_s = 60.0;  // of a recording; of an endless hand as long

double mean_speed_m_per_s(const Target& hand) {
  double way_m = 0.0;
  const auto ticks = static_cast<int>(1e3 * std::min(hand.duration_s(), 60.0));
  for (int tick = 0; tick < ticks; ++tick)
    way_m += distance(hand.at(1e-3 * tick).position_m, hand.at(1e-3 * (tick + 1)).position_m);
  return way_m / (1e-3 * ticks);
}

void print_row(const std::vector<std::shared_ptr<const Target>>& hands, double speed_m_per_s, double voxel_hand_m,
               const ChunkSupply& supply) {
  std::vector<std::array<std::int64_t, 3>> chunks(6, {32, 32, 32});
  ForecastStore store;
  store.finest.dims = {4096, 4096, 4096};
  store.finest.index_to_world_m = Mat3{{{1e-6, 0, 0}, {0, 1e-6, 0}, {0, 0, 1e-6}}};
  store.chunks = chunks;
  const Similarity hand_to_world{.scale = 1e-6 / voxel_hand_m, .translation_m = {2.048e-3, 2.048e-3, 2.048e-3}};
  OctaveForecast mean;
  double ticks = 0.0;
  for (const auto& hand : hands) {
    const double speed = speed_m_per_s / mean_speed_m_per_s(*hand);
    const double duration_s = std::min(longest_s, hand->duration_s() / speed);
    const OctaveForecast one = forecast_octaves(store, *hand, hand_to_world, speed, duration_s, supply);
    const double share = 1.0 / static_cast<double>(hands.size());
    mean.felt.finest_share += share * one.felt.finest_share;
    mean.felt.as_fine_as_way_share += share * one.felt.as_fine_as_way_share;
    mean.felt.forced_ticks += one.felt.forced_ticks;
    ticks += 1e3 * duration_s;
    mean.chunks_per_s += share * one.chunks_per_s;
    mean.most_per_s = std::max(mean.most_per_s, one.most_per_s);
  }
  std::printf("%8.2f %9.1f %9.2f x %d %8.1f %8.1f %8.3f %9.0f %9.0f\n", speed_m_per_s, 1e6 * voxel_hand_m, 1e3 * supply.chunk_s,
              supply.at_once, 100.0 * mean.felt.finest_share, 100.0 * mean.felt.as_fine_as_way_share,
              100.0 * static_cast<double>(mean.felt.forced_ticks) / ticks, mean.chunks_per_s, mean.most_per_s);
  std::fflush(stdout);
}

/// The scene with its volume in memory, or felt through windows.
PreparedRun prepared(const char* scene, const std::string& volume, const char* hand, const char* memory_mb) {
  RunOptions options;
  options.scene = scene;
  options.hand = hand;
  options.scene_options.sets = {{"volume." + volume + ".memory_mb", memory_mb}};
  return prepare(options);
}

double thread_us() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
}

/// Ticks of one hand in both, in turn: processor time by work, and whether they feel equal forces.
int compare_ticks(const char* scene, const std::string& volume, const char* hand) {
  const PreparedRun whole = prepared(scene, volume, hand, "100000"), windows = prepared(scene, volume, hand, "1");
  Session in_memory(whole.loaded.scene), in_windows(windows.loaded.scene);
  WindowFeed feed(in_windows);
  std::vector<double> memory_us, windows_us;
  int different = 0;
  const double felt_s = std::min(whole.duration_s, 30.0);
  for (int tick = 0; tick < static_cast<int>(1e3 * felt_s); ++tick) {
    const Probe probe{.position_m = whole.target->at(1e-3 * tick).position_m};
    feed.lay_for(probe, 1e-3);
    const double begin_us = thread_us();
    const Tick a = in_memory.tick(probe, 1e-3);
    const double middle_us = thread_us();
    const Tick b = in_windows.tick(probe, 1e-3);
    const double end_us = thread_us();
    memory_us.push_back(middle_us - begin_us), windows_us.push_back(end_us - middle_us);
    different += a.force_n != b.force_n;
  }
  const auto report = [](const char* name, std::vector<double>& times_us) {
    double sum_us = 0.0;
    for (const double time_us : times_us) sum_us += time_us;
    std::ranges::sort(times_us);
    const double mean_us = sum_us / static_cast<double>(times_us.size());
    std::printf("%-12s mean %7.2f us, p50 %7.2f us, p99 %7.2f us\n", name, mean_us, times_us[times_us.size() / 2],
                times_us[times_us.size() * 99 / 100]);
    return mean_us;
  };
  const double memory_mean_us = report("in memory", memory_us), windows_mean_us = report("windows", windows_us);
  std::printf("ratio of means %.3f; %d of %zu ticks feel another force\n", windows_mean_us / memory_mean_us, different,
              memory_us.size());
  return different > 0 ? 1 : 0;
}

int run(int argc, char** argv) {
  if (argc == 5 && std::strcmp(argv[1], "ticks") == 0) return compare_ticks(argv[2], argv[3], argv[4]);
  std::vector<std::shared_ptr<const Target>> hands;
  bool is_quick = false;
  for (int n = 1; n < argc; ++n) {
    const std::string name = argv[n];
    if (name == "--quick")
      is_quick = true;
    else if (name.starts_with("sim:"))
      hands.push_back(simulated_target(name));
    else
      hands.push_back(recorded_target(name, {}));
  }
  if (hands.empty()) {
    std::fputs("bench_octaves HAND... [--quick] | ticks SCENE VOLUME HAND: recordings, or sim:random\n", stderr);
    return 2;
  }
  std::printf("%8s %9s %13s %8s %8s %8s %9s %9s\n", "m/s", "um/voxel", "ms/chunk", "% oct. 0", "% fine", "% forced", "chunks/s",
              "most/s");
  const ChunkSupply disk{}, memory{.chunk_s = 0.03e-3, .at_once = 1}, network{.chunk_s = 2e-3, .at_once = 8},
      slow{.chunk_s = 10e-3, .at_once = 8};
  for (const double voxel_m : {36.6e-6, 146e-6}) {
    for (const ChunkSupply& supply : {disk, memory, network, slow}) {
      for (const double speed : {0.05, 0.2, 1.0}) print_row(hands, speed, voxel_m, supply);
      if (is_quick) return 0;
    }
  }
  for (const double voxel_m : {36.6e-6, 146e-6, 586e-6, 2340e-6})
    for (const double speed : {0.01, 0.03, 0.1, 0.5, 3.0}) print_row(hands, speed, voxel_m, disk);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const palpa::LoadError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
