// Octaves that hands would feel of a large store, in virtual time: bench_octaves HAND... [--quick]
//
// HAND: a recording, or sim:random. 4096³ voxels in chunks of 32³, of which a voxel is 36.6, 146 or 2340 µm of the hand; mean
// speeds of 0.01 to 3 m/s; chunks from memory, a disk, and two networks. Compare with the table of docs/large.md.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/device/hand.h"
#include "palpa/study/octave_forecast.h"

namespace {

using namespace palpa;

constexpr double duration_s = 8.0;

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
  for (const auto& hand : hands) {
    const OctaveForecast one =
        forecast_octaves(store, *hand, hand_to_world, speed_m_per_s / mean_speed_m_per_s(*hand), duration_s, supply);
    const double share = 1.0 / static_cast<double>(hands.size());
    mean.felt.finest_share += share * one.felt.finest_share;
    mean.felt.as_fine_as_way_share += share * one.felt.as_fine_as_way_share;
    mean.felt.forced_ticks += one.felt.forced_ticks;
    mean.chunks_per_s += share * one.chunks_per_s;
    mean.most_per_s = std::max(mean.most_per_s, one.most_per_s);
  }
  std::printf("%8.2f %9.1f %9.2f x %d %8.1f %8.1f %8.3f %9.0f %9.0f\n", speed_m_per_s, 1e6 * voxel_hand_m, 1e3 * supply.chunk_s,
              supply.at_once, 100.0 * mean.felt.finest_share, 100.0 * mean.felt.as_fine_as_way_share,
              100.0 * static_cast<double>(mean.felt.forced_ticks) / (8000.0 * static_cast<double>(hands.size())),
              mean.chunks_per_s, mean.most_per_s);
  std::fflush(stdout);
}

int run(int argc, char** argv) {
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
    std::fputs("bench_octaves HAND... [--quick]: recordings, or sim:random\n", stderr);
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
